// Sorts and filters without losing the reader's place, and copies. Without it, every link and form loads a page.
"use strict";
(() => {
  let shown = location.pathname + location.search;
  let latest = 0; // number of pages asked for: an answer to an earlier question comes too late
  const say = (text) => { document.getElementById("said").textContent = text; };

  async function show(address, remember) {
    const focused = document.activeElement?.closest("[data-swap]")?.dataset.swap;
    const place = document.querySelector(".board")?.scrollLeft ?? 0;
    const mine = ++latest, response = await fetch(address), text = await response.text();
    if (mine !== latest) return;
    if (!response.ok) { location.assign(address); return; }
    const page = new DOMParser().parseFromString(text, "text/html");
    if (remember) history.pushState(null, "", address);
    shown = location.pathname + location.search;
    for (const part of ["header", "main"]) {
      document.querySelector(part).replaceWith(page.querySelector(part));
    }
    document.title = page.title;
    prepare();
    const box = document.querySelector(".board");
    if (box) box.scrollLeft = place;
    if (focused) document.querySelector(`[data-swap="${CSS.escape(focused)}"]`)?.focus({ preventScroll: true });
    say(document.querySelector("caption .stay")?.textContent ?? document.title);
  }

  function follow(address) {
    const mine = latest + 1;
    return show(address, true).catch(() => { if (mine === latest) location.assign(address); });
  }

  document.addEventListener("click", (event) => {
    const link = event.target.closest("a[data-swap]");
    if (!link || event.ctrlKey || event.metaKey || event.shiftKey || event.altKey || event.button) return;
    event.preventDefault();
    follow(link.href);
  });

  document.addEventListener("submit", (event) => {
    const form = event.target.closest("form[data-swap]");
    if (!form) return;
    event.preventDefault();
    const address = new URL(form.action);
    address.search = new URLSearchParams(new FormData(form));
    follow(address.href);
  });

  addEventListener("popstate", () => {
    if (location.pathname + location.search === shown) return; // to a place on the same page
    show(location.href, false).catch(() => location.reload());
  });

  // On a narrow screen the column that sorts may lie beyond the edge.
  function uncover() {
    const box = document.querySelector(".board"), column = box?.querySelector("[aria-sort]");
    if (!column) return;
    const beyond = column.getBoundingClientRect().right - box.getBoundingClientRect().right;
    if (beyond > 0) box.scrollLeft += beyond + 14; // clear of the shade
  }

  // Whatever the font: what has the focus is not under the headings or the pinned columns.
  document.addEventListener("focusin", (event) => {
    const box = event.target.closest(".board"), cell = event.target.closest("th, td");
    if (!box || !cell) return;
    const seen = event.target.getBoundingClientRect();
    const pinned = [...box.querySelectorAll("thead .pin")].map((one) => one.getBoundingClientRect().right);
    const under = Math.max(...pinned) - seen.left;
    if (under > 0 && !cell.matches(".pin")) box.scrollLeft -= under + 14;
    if (box.querySelector("thead").getBoundingClientRect().bottom > seen.top && !cell.closest("thead")) {
      event.target.scrollIntoView({ block: "center", inline: "nearest" });
    }
  });

  function prepare() {
    for (const line of document.querySelectorAll("[data-copy]")) {
      if (!navigator.clipboard) return;
      const button = document.createElement("button");
      button.type = "button";
      button.textContent = line.dataset.copy;
      button.addEventListener("click", async () => {
        await navigator.clipboard.writeText(line.textContent);
        say(button.textContent = line.dataset.copied);
      });
      line.after(button);
    }
  }
  prepare();
  uncover();
})();

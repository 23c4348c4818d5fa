// The theme puts each table into a frame that scrolls if the table is wider than the page. Keyboards reach such a frame
// only if it can have the focus.
const updateFrames = () => {
  for (const frame of document.querySelectorAll(".md-typeset__scrollwrap")) {
    if (frame.scrollWidth > frame.clientWidth) frame.tabIndex = 0
    else frame.removeAttribute("tabindex")
  }
}
new MutationObserver(updateFrames).observe(document.body, { childList: true, subtree: true })
new ResizeObserver(updateFrames).observe(document.body)

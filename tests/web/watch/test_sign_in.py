"""Sign-in to the watch pages: a token is exchanged for a pass, with which its participant's own runs can be watched."""

import http.client
import re
import time
from collections.abc import Iterator
from contextlib import contextmanager
from urllib.parse import urlencode

import pytest
import sqlalchemy as sa
from playwright.sync_api import Browser, expect

from arramon_server.api.authentication import Authentication
from arramon_server.api.stream_limits import StreamLimits
from arramon_server.configuration.config import Config
from arramon_server.errors import Unauthenticated
from arramon_server.process.browser_admission import browser_access
from arramon_server.runs.accounts.accounts import Accounts
from arramon_server.runs.accounts.callers import Caller, Role
from arramon_server.runs.accounts.quotas import DefaultQuotas, Quotas
from arramon_server.runs.accounts.watch_passes import PASS_SECONDS, WatchPasses
from arramon_server.runs.storage import tables
from arramon_server.runs.storage.records import CANCELLED
from arramon_server.web.watch.sign_in import COOKIE, SignIn
from arramon_server.web.watch.viewers import Viewers
from tests.web.leaderboard_site import HIDDEN_RUN, OPEN_RUN, LeaderboardSite
from tests.web.serving import Site
from tests.web.watch.test_access import EPISODE, LIVE_RUN, addresses, served, statuses, truth_of

SAME_SITE = {"Sec-Fetch-Site": "same-origin"}


@contextmanager
def signing(backend: LeaderboardSite, *, anonymous: bool = False, trust_proxy: bool = False) -> Iterator[Site]:
    """The backend's pages on a server where participants sign in under the rules of gRPC calls."""
    config = Config(anonymous=anonymous, trust_proxy=trust_proxy, data=backend.folder)
    authentication = Authentication(Accounts(backend.database), config)
    limits = StreamLimits(Quotas(backend.database, DefaultQuotas(config, [])), "worker")
    sign_in = SignIn(browser_access(authentication, limits, config).authenticate, WatchPasses(backend.database))
    with served(backend, Viewers(anonymous, sign_in=sign_in)) as site:
        yield site


def post(site: Site, path: str, body: str, headers: dict[str, str]) -> tuple[int, dict[str, str], str]:
    connection = http.client.HTTPConnection("127.0.0.1", site.port, timeout=120)
    form = {"Content-Type": "application/x-www-form-urlencoded", **headers}
    connection.request("POST", path, body, form)
    response = connection.getresponse()
    found = {name.lower(): value for name, value in response.getheaders()}
    text = response.read().decode()
    connection.close()
    return response.status, found, text


def signed_in(site: Site, token: str) -> dict[str, str]:
    """Sign in, and return the headers that the browser then sends."""
    status, headers, _ = post(site, "/en/watch/sign-in", urlencode({"token": token}), SAME_SITE)
    assert (status, headers["location"]) == (303, "/en/watch")
    return {"Cookie": headers["set-cookie"].partition(";")[0]}


@pytest.fixture
def owned(web: LeaderboardSite) -> LeaderboardSite:
    """With an unpublished run of ann, of which one episode is being played."""
    accounts = Accounts(web.database)
    for name, role in (("ann", Role.PARTICIPANT), ("bob", Role.PARTICIPANT), ("chair", Role.HOST)):
        tokens[name] = accounts.create_token(name, role)
    web.run(LIVE_RUN, split="open", participant="ann", account="ann", over=False)
    web.journal.claim(LIVE_RUN, [one for one in web.journal.pending(LIVE_RUN) if one.episode_id == EPISODE], "p", "w")
    return web


tokens: dict[str, str] = {}
"""The token of each participant."""


def test_a_server_for_accounts_says_that_runs_are_listed_after_sign_in(owned: LeaderboardSite) -> None:
    with signing(owned) as site:
        headers = signed_in(site, tokens["ann"])
        for page, said in (("/en/watch", "listed after you sign in"), ("/hi/watch", "साइन इन करने के बाद यहाँ दिखते हैं")):
            assert said in site.get(page).text
            assert said not in site.get(page, headers).text


@pytest.mark.parametrize(("name", "status"), [("ann", 200), ("chair", 200), ("bob", 404)])
def test_own_runs_can_be_watched_and_those_of_others_cannot(owned: LeaderboardSite, name: str, status: int) -> None:
    with signing(owned) as site:
        pages = [address for address in addresses(LIVE_RUN) if not address.endswith("step=3")]
        assert statuses(site, LIVE_RUN) == {404}
        headers = signed_in(site, tokens[name])
        assert {site.get(page, headers).status for page in pages} == {status}
        assert {site.get(page).status for page in pages} == {404}
        listed = site.get("/en/watch", headers).text
        assert (LIVE_RUN in listed) is (status == 200)
        assert f"Signed in as <bdi>{name}</bdi>" in listed


@pytest.mark.parametrize("published", [True, False])
def test_a_hidden_split_is_watched_by_hosts_alone_and_kept_by_no_cache(owned: LeaderboardSite, published: bool) -> None:
    if published:
        owned.play(HIDDEN_RUN, "hidden")
    else:
        owned.run(HIDDEN_RUN, split="hidden", participant="ann", account="ann")
    with signing(owned) as site:
        pages = [*addresses(HIDDEN_RUN), f"/en/runs/{HIDDEN_RUN}/failures", f"/en/runs/{HIDDEN_RUN}/differences"]
        for headers in ({}, signed_in(site, tokens["ann"]), signed_in(site, tokens["bob"])):
            assert {site.get(page, headers).status for page in pages} == {404}
            assert HIDDEN_RUN not in site.get("/en/watch", headers).text
        chair = signed_in(site, tokens["chair"])
        got = [site.get(page, chair) for page in pages]
        assert [(page, one.status) for page, one in zip(pages, got, strict=True)] == [(page, 200) for page in pages]
        assert all(one.headers["cache-control"].startswith("private") for one in got)
        assert HIDDEN_RUN in site.get("/en/watch", chair).text
        assert {site.get(page).status for page in pages} == {404}


def test_who_plays_a_run_is_not_shown_where_it_leads(owned: LeaderboardSite) -> None:
    with signing(owned) as site:
        for name in ("ann", "chair"):
            headers = signed_in(site, tokens[name])
            assert not truth_of(site.get(f"/en/runs/{LIVE_RUN}/episodes/{EPISODE}", headers))
            assert not truth_of(site.get(f"/en/runs/{LIVE_RUN}/episodes/{EPISODE}/moments.json", headers))


def test_what_not_everybody_may_see_is_kept_by_no_cache(owned: LeaderboardSite) -> None:
    owned.play(OPEN_RUN, "open")
    with signing(owned) as site:
        headers = signed_in(site, tokens["ann"])
        for path in (f"/en/runs/{LIVE_RUN}/episodes/{EPISODE}", f"/en/runs/{OPEN_RUN}/episodes/{EPISODE}", "/en/watch"):
            got = site.get(path, headers)
            assert (got.status, got.headers["cache-control"]) == (200, "private, no-store")
        public = site.get(f"/en/runs/{OPEN_RUN}/episodes/{EPISODE}")
        assert (public.headers["cache-control"], public.headers["vary"]) == (
            "public, max-age=15",
            "Accept-Encoding, Cookie",
        )
        assert "Cookie" in site.get(f"/en/runs/{LIVE_RUN}/episodes/{EPISODE}").headers["vary"]


def test_the_cookie_is_narrow_and_is_no_token(owned: LeaderboardSite) -> None:
    with signing(owned) as site:
        for host, secure in (("localhost", False), ("board.example", True)):
            body = urlencode({"token": tokens["ann"]})
            _, headers, _ = post(site, "/hi/watch/sign-in", body, {**SAME_SITE, "Host": host})
            name, *options = headers["set-cookie"].split("; ")
            assert set(options) == {"HttpOnly", "Path=/", "SameSite=Strict", *(["Secure"] if secure else [])}
            assert headers["location"] == "/hi/watch"
        value = name.partition("=")[2]
        assert tokens["ann"].rpartition("_")[2] not in value
        with pytest.raises(Unauthenticated):
            Accounts(owned.database).caller(value)
        assert site.get("/en/watch", {"Cookie": f"{COOKIE}={tokens['ann']}"}).text.count("Signed in as") == 0


@pytest.mark.parametrize(
    ("body", "headers", "expected"),
    [
        ("token=arramon_0000_x", SAME_SITE, "This token is not accepted"),
        ("token=<b>", SAME_SITE, "This token is not accepted"),
        ("", SAME_SITE, "This token is not accepted"),
        ("token=" + "x" * 3000, SAME_SITE, "This token is not accepted"),
        ("{ann}", {**SAME_SITE, "Content-Type": "text/plain"}, "This token is not accepted"),
        ("{ann}", {"Sec-Fetch-Site": "cross-site"}, "Nothing was done"),
        ("{ann}", {}, "Nothing was done"),
    ],
)
def test_refused_sign_ins_say_why(owned: LeaderboardSite, body: str, headers: dict[str, str], expected: str) -> None:
    sent = body.replace("{ann}", urlencode({"token": tokens["ann"]}))
    with signing(owned) as site:
        status, answer, text = post(site, "/en/watch/sign-in", sent, headers)
        assert (status, "set-cookie" in answer) == (403, False)
        assert expected in text
        assert tokens["ann"] not in text
        assert site.get(f"/en/watch/sign-in?{urlencode({'token': tokens['ann']})}").status == 404  # never in an address


@pytest.mark.parametrize("headers", [{"X-Forwarded-For": "192.0.2.1"}, {}])
def test_tokens_are_taken_where_grpc_takes_them(owned: LeaderboardSite, headers: dict[str, str]) -> None:
    with signing(owned, trust_proxy=True) as site:
        status, _, _ = post(site, "/en/watch/sign-in", urlencode({"token": tokens["ann"]}), {**SAME_SITE, **headers})
        assert status == 303


def test_signing_out_removes_the_cookie(owned: LeaderboardSite) -> None:
    with signing(owned) as site:
        headers = signed_in(site, tokens["ann"])
        assert post(site, "/en/watch/sign-out", "", headers)[0] == 403  # another site cannot
        status, answer, _ = post(site, "/en/watch/sign-out", "", {**headers, **SAME_SITE})
        assert status == 303
        assert answer["set-cookie"].startswith(f'{COOKIE}=""')


def test_passes_end(owned: LeaderboardSite, monkeypatch: pytest.MonkeyPatch) -> None:
    passes, token = WatchPasses(owned.database), tokens["ann"]
    watch_pass = passes.issue(token)
    assert passes.caller(watch_pass) == Caller(Role.PARTICIPANT, "ann")
    token_id, expiry, mac = watch_pass.split(".")
    for forged in (
        f"{token_id}.{int(expiry) + 1}.{mac}",
        f"{passes.issue(tokens['bob']).partition('.')[0]}.{expiry}.{mac}",
        f"{token_id}.{expiry}.",
        f"{token_id}..{mac}",
        f"{token_id}.{expiry}.{mac}" + "0" * 200,
        f"{token_id}.٣.{mac}",
        "..",
        "",
    ):
        with pytest.raises(Unauthenticated, match="not valid"):
            passes.caller(forged)
    now = time.time()
    with monkeypatch.context() as later:
        later.setattr(time, "time", lambda: now + PASS_SECONDS + 1)
        with pytest.raises(Unauthenticated, match="expired"):
            passes.caller(watch_pass)
    Accounts(owned.database).revoke(token_id)
    with pytest.raises(Unauthenticated, match="revoked"):
        passes.caller(watch_pass)
    with owned.database.write() as connection:
        connection.execute(sa.delete(tables.tokens).where(tables.tokens.c.token_id == token_id))
    with pytest.raises(Unauthenticated, match="not valid"):
        passes.caller(watch_pass)


def test_a_participant_signs_in_watches_and_signs_out(owned: LeaderboardSite, browser: Browser) -> None:
    with signing(owned) as site:
        context = browser.new_context()
        page = context.new_page()
        page.goto(f"{site.address}/en/watch")
        page.get_by_label("Token").fill("arramon_0000_wrong")
        page.keyboard.press("Enter")
        expect(page.get_by_role("alert")).to_contain_text("not accepted")
        page.get_by_label("Token").fill(tokens["ann"])
        page.get_by_role("button", name="Sign in").click()
        expect(page.get_by_text("Signed in as ann.")).to_be_visible()
        assert re.search(r"/en/watch$", page.url)
        page.get_by_role("link", name=EPISODE).first.click()
        page.wait_for_selector("#watch[data-ready]", state="attached")
        assert page.evaluate("document.cookie") == ""  # not for scripts
        page.goto(f"{site.address}/hi/watch")
        page.get_by_role("button", name="साइन आउट").click()
        expect(page.get_by_role("button", name="साइन इन")).to_be_visible()
        answer = page.goto(f"{site.address}/en/runs/{LIVE_RUN}/episodes/{EPISODE}")
        assert answer is not None
        assert answer.status == 404
        context.close()


def test_failures_of_own_runs_are_shown_once_they_have_ended(owned: LeaderboardSite) -> None:
    page = f"/en/runs/{LIVE_RUN}/failures"
    with signing(owned) as site:
        headers = signed_in(site, tokens["ann"])
        assert site.get(page, headers).status == 404
        assert page not in site.get("/en/watch", headers).text
        owned.journal.set_state(LIVE_RUN, CANCELLED)
        assert page in site.get("/en/watch", headers).text
        got = site.get(page, headers)
        assert (got.status, got.headers["cache-control"]) == (200, "private, no-store")
        assert {site.get(page, other).status for other in ({}, signed_in(site, tokens["bob"]))} == {404}

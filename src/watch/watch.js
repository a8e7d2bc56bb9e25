"use strict";
// Follows `nailnoise watch`: what the bar says, and each new report in place of the old one, at the same place of the page.
(() => {
  const part = (id) => document.getElementById(id);
  const [bar, status, failure, place] = ["bar", "status", "failure", "report"].map(part);
  let wanted = null, markup = null;

  // Charts may take long to draw: the new report is shown when they are there, or after a second.
  const drawn = (frame) => Promise.race([frame.contentWindow.nailnoise?.ready, new Promise((done) => setTimeout(done, 1000))]);

  const takeOver = (from, to) => {
    const open = (frame) => [...frame.contentDocument.querySelectorAll("details")];
    const before = open(from), after = open(to);
    if (before.length === after.length) after.forEach((own, i) => { own.open = before[i].open; });
    to.contentWindow.scrollTo({ left: from.contentWindow.scrollX, top: from.contentWindow.scrollY, behavior: "instant" });
  };

  const bring = (number) => {
    wanted = number;
    place.querySelectorAll("iframe.next").forEach((frame) => frame.remove());
    const next = document.createElement("iframe");
    Object.assign(next, { title: "Report of the last run", className: "next", src: "report?" + number });
    next.addEventListener("load", async () => {
      await drawn(next);
      if (wanted !== number) return;
      const old = place.querySelector("iframe:not(.next)");
      if (old) takeOver(old, next);
      next.classList.remove("next");
      if (old) old.remove();
      // For whoever looks after the page from outside.
      document.documentElement.dataset.shown = number;
    }, { once: true });
    place.append(next);
  };

  const events = new EventSource("events");
  events.onmessage = ({ data }) => {
    const news = JSON.parse(data);
    document.body.classList.remove("gone");
    document.title = news.title;
    status.textContent = news.status;
    if (failure.textContent !== (news.failure ?? "")) failure.textContent = news.failure ?? "";
    failure.hidden = news.failure === null;
    if (markup !== news.bar) {
      const focused = document.activeElement?.dataset?.post;
      bar.innerHTML = markup = news.bar;
      if (focused) bar.querySelector("button")?.focus();
    }
    if (news.report !== null && news.report !== wanted) bring(news.report);
  };
  events.onerror = () => {
    document.body.classList.add("gone");
    status.textContent = "nailnoise watch has ended; this is its last result";
  };
  bar.addEventListener("click", ({ target }) => {
    const post = target.closest("button")?.dataset.post;
    if (post) fetch(post, { method: "POST" });
  });
})();

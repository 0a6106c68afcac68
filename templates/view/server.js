// Speaking with the server: every request carries the token, and every refusal is told.

const token = new URLSearchParams(location.search).get("token") ?? "";

const tell = (text) => { byId("status").textContent = text; };

const complain = (refusal) => {
  const box = byId("message");
  box.hidden = !refusal;
  if (!refusal) return draw(box);
  const close = element("button", { type: "button", onclick: () => complain(null) }, "Close");
  draw(box, element("div", {}, refusal.message.split("\n").map((line) => element("p", {}, line))), close);
  box.scrollIntoView({ block: "nearest" });
};

// The answer to a request; a refusal is thrown as it is. `stamp`: the campaign that a change is meant for.
const ask = async (path, post, stamp) => {
  const request = { headers: { "X-Hydrosysid-Token": token, ...(stamp && { "X-Hydrosysid-Stamp": stamp }) } };
  if (post !== undefined) {
    request.method = "POST";
    request.body = post instanceof Blob ? post : JSON.stringify(post);
  }
  let answer;
  try {
    answer = await fetch(path, request);
  } catch {
    throw { message: "the server does not answer: was `hydrosysid view` ended?", gone: true };
  }
  const said = await answer.json().catch(() => ({ message: `the server answered with ${answer.status}` }));
  if (!answer.ok) throw said;
  return said;
};

const query = (path, pairs) => `${path}?${new URLSearchParams(pairs)}`;

// Does what was asked for; a refusal is shown and the page drawn as the file is.
const attempt = async (what, work) => {
  try {
    complain(null);
    tell(what);
    await work();
    tell("");
  } catch (refusal) {
    tell("");
    if (!refusal.message) throw refusal;
    complain(refusal);
    if (!refusal.gone) await view.reload();
  }
};

// Changes of the campaign, one after the other: the file is written first, then the page follows it.
let changes = Promise.resolve();
const change = (path, body) => {
  changes = changes.then(() => attempt("saving", async () => view.show(await ask(path, body, view.campaign.stamp))));
  return changes;
};

// Work that goes on: what it is at, how far, and a button to end it.
const work = (box, name, progress) => {
  box.hidden = !progress.running;
  if (!progress.running) return draw(box);
  const part = progress.of ? `${progress.step} ${progress.done}/${progress.of}` : progress.step;
  // made once: a button that is drawn anew between press and release is never clicked
  if (!box.firstChild) {
    const stop = element("button", {
      type: "button", id: `stop-${name}`, onclick: () => attempt("stopping", () => ask("/api/stop", { name })),
    }, "Stop");
    draw(box, element("progress", { "aria-labelledby": `step-${name}` }), element("span", { id: `step-${name}` }), stop);
  }
  const [bar, said] = box.children;
  if (progress.of) Object.assign(bar, { max: progress.of, value: progress.done });
  else bar.removeAttribute("value");
  said.textContent = `${part} (${progress.seconds.toFixed(0)} s)`;
};

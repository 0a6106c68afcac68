// Logs: dropped or chosen, kept beside the campaign, made runs of it; one of them is looked at.

const logs = {
  // The log that columns and stretches are of.
  chosen: null,

  setUp() {
    const drop = byId("drop"), input = byId("files");
    for (const kind of ["dragenter", "dragover"]) {
      document.addEventListener(kind, (event) => {
        event.preventDefault();
        drop.classList.add("over");
      });
    }
    document.addEventListener("dragleave", (event) => {
      if (!event.relatedTarget) drop.classList.remove("over");
    });
    document.addEventListener("drop", (event) => {
      event.preventDefault();
      drop.classList.remove("over");
      this.add([...event.dataTransfer.files]);
    });
    input.addEventListener("change", () => {
      const files = [...input.files];
      input.value = "";
      this.add(files);
    });
  },

  add(files) {
    if (!files.length) return;
    return attempt("", async () => {
      for (const file of files) {
        tell(`reading ${file.name}`);
        await ask(query("/api/log", { name: file.name }), file);
      }
      tell("understanding the logs");
      const mass = parseFloat(byId("new-mass").value);
      this.chosen = files[0].name;
      view.show(await ask("/api/runs", {
        files: files.map((file) => file.name), vehicle: byId("known-vehicle").value || null,
        name: byId("new-name").value || null, mass: Number.isFinite(mass) ? mass : null,
      }));
    });
  },

  show(campaign) {
    const isNew = !campaign.exists;
    byId("new").hidden = !isNew;
    if (isNew && !byId("known-vehicle").options.length) {
      const none = option("", "not one of these");
      draw(byId("known-vehicle"), none, campaign.vehicles.map((name) => option(name, name)));
    }
    if (!campaign.logs.some((log) => log.file === this.chosen)) this.chosen = campaign.logs[0]?.file ?? null;
    this.draw(campaign, null);
  },

  // The list, with its lights once the check has looked.
  draw(campaign, check) {
    if (!campaign.logs.length) return draw(byId("log-list"));
    const row = (log, k) => {
      const checked = log.stretches.map((s) => check?.logs.find((c) => c.file === s.name)).filter(Boolean);
      const order = ["green", "amber", "red"];
      const worst = checked.map((c) => c.verdict).sort((a, b) => order.indexOf(b) - order.indexOf(a))[0];
      const roles = log.stretches.map((s) => s.role);
      const role = roles.every((r) => r === "train") ? "trains" : roles.every((r) => r === "validate") ? "judges" : "both";
      const pick = element("button", {
        type: "button", class: "pick", id: `log-${k}`, "aria-pressed": String(log.file === this.chosen),
        onclick: () => this.choose(log.file),
      }, log.files.join(" + "));
      const sum = (key) => checked.reduce((all, c) => all + c[key], 0);
      const topics = (checked[0]?.lights ?? []).map((l) => element("span", { class: "topic" }, light(l.light, l.topic), l.topic));
      return element("tr", { class: log.file === this.chosen ? "chosen" : null },
        cell(check ? light(worst) : element("span", { class: "light off", title: "being looked at" }, "…")), cell(pick),
        cell(role), element("td", { class: "num" }, checked.length ? String(sum("rows")) : ""),
        element("td", { class: "num" }, checked.length ? `${sum("duration").toFixed(1)} s` : ""), element("td", { class: "topics" }, topics));
    };
    const heads = ["", "log", "use", "rows", "used", "what was looked at"];
    const others = [...(check?.errors ?? []), ...(check?.warnings ?? [])].filter((f) => !f.run);
    draw(byId("log-list"), table(heads, campaign.logs.map(row), "Logs"), findings(others));
  },

  choose(file) {
    this.chosen = file;
    this.draw(view.campaign, view.check);
    view.look();
  },
};

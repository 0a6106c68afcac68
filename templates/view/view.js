// The page as a whole: it shows what the campaign file says, follows it when it changes, and asks how far the work is.

const view = {
  campaign: null,
  check: null,
  timer: 0,
  // Number of the last question how far the work is.
  question: 0,

  // Shows the campaign as the server read it.
  show(campaign) {
    const changed = campaign.stamp !== this.campaign?.stamp;
    this.campaign = campaign;
    const usable = campaign.exists && !campaign.problem;
    byId("vehicle").textContent = campaign.vehicle || "hydrosysid";
    document.title = campaign.vehicle ? `${campaign.vehicle}: hydrosysid` : "hydrosysid";
    byId("file").textContent = campaign.exists ? campaign.file : `${campaign.file}, not there yet`;
    byId("undo").disabled = !campaign.can_undo;
    byId("campaign-text").textContent = campaign.text;
    for (const id of ["model", "missing", "save"]) byId(id).hidden = !usable;
    if (campaign.problem) complain(campaign.problem);
    logs.show(campaign);
    effects.show(campaign);
    discovery.show();
    if (!usable) {
      for (const id of ["columns", "stretches"]) byId(id).hidden = true;
      return;
    }
    if (!changed) return logs.draw(campaign, this.check);
    this.look();
    this.judge();
    attempt("", () => fit.begin());
  },

  // Columns and stretches of the chosen log.
  look() {
    for (const part of [columns, stretches]) part.show(this.campaign, logs.chosen).catch((refusal) => complain(refusal));
  },

  // The lights of the logs.
  async judge() {
    const stamp = this.campaign.stamp;
    const check = await ask("/api/check").catch((refusal) => complain(refusal));
    if (!check || stamp !== this.campaign.stamp) return;
    this.check = check;
    logs.draw(this.campaign, check);
  },

  async reload() {
    this.show(await ask("/api/campaign"));
  },

  // Asks how far the work is: often while something is at work.
  async poll() {
    clearTimeout(this.timer);
    const question = ++this.question;
    // what an older question hears is not shown over what a newer one has heard
    const isStale = () => question !== this.question;
    let wait = 1500;
    try {
      const progress = await ask("/api/progress");
      if (!isStale() && progress.stamp !== this.campaign?.stamp) await this.reload();
      for (const [name, part] of Object.entries({ fit, discovery, report })) {
        if (isStale()) return;
        await part.follow(progress[name]);
      }
      if (progress.fit.running || progress.discovery.running || progress.report.running) wait = 200;
    } catch (refusal) {
      complain(refusal);
      wait = 4000;
    }
    if (isStale()) return;
    this.timer = setTimeout(() => this.poll(), wait);
  },

  async begin() {
    for (const part of [logs, stretches, effects, fit, discovery, report]) part.setUp();
    byId("undo").addEventListener("click", () => change("/api/undo", {}));
    await attempt("", () => this.reload());
    this.poll();
  },
};

view.begin();

// The head of the page says how the flight goes, and when the page has lost it.
cc.beginHead = () => {
  const line = document.querySelector(".cc-status");
  if (!line || line.dataset.on) return;
  line.dataset.on = "1";
  let shown = "";
  // the battery that ends the flight first
  const weakest = () => {
    const known = (cc.words.cards || []).map((card, i) => [card.battery, cc.setting.names[i]]).filter(([volts]) => volts !== null);
    if (!known.length) return "";
    const [volts, name] = known.reduce((one, other) => (other[0] < one[0] ? other : one));
    return `, lowest battery ${volts.toFixed(2)} V (${name})`;
  };
  const tell = () => {
    let text = "", hasFailed = false;
    const isLost = !cc.connected || cc.words.error;
    if (cc.setting?.is_watched && cc.words.error) text = cc.words.error;
    else if (!cc.connected) text = "No connection to the flight; it goes on. Trying again.";
    else if (cc.words.error) text = cc.words.error;
    else if (!cc.frame || !cc.setting) text = "The drones get ready";
    else {
      const up = cc.frame.drones.filter((drone) => drone.phase === "flying" || drone.phase === "landing").length;
      const pace = cc.words.speed === 0 ? "paused" : cc.frame.rate.toFixed(1) + " x real time";
      text = `${cc.frame.time.toFixed(1)} s, ${pace}, ${up} of ${cc.frame.drones.length} in the air, ${cc.setting.backend}${weakest()}`;
      const failed = (cc.words.cards || []).filter((card) => card.failure).length;
      if (failed) text += `, ${failed} FAILED`;
      hasFailed = failed > 0;
    }
    line.classList.toggle("cc-lost", !!isLost || hasFailed);
    if (text !== shown) { shown = text; line.textContent = text; line.title = text; }
  };
  setInterval(tell, cc.isSlow() ? 1000 : 200);
  const saved = localStorage.getItem("cc-dark");
  if (saved !== null) Quasar.Dark.set(saved === "1");
};

cc.toggleDark = () => {
  Quasar.Dark.toggle();
  localStorage.setItem("cc-dark", Quasar.Dark.isActive ? "1" : "0");
  window.dispatchEvent(new Event("resize"));
  ["frame", "drawings", "shown"].forEach((name) => cc.emit(name, name === "frame" ? cc.frame : ""));
};

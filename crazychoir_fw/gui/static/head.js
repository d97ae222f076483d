// The head of the page says how the flight goes, and when the page has lost it.
cc.beginHead = () => {
  const line = document.querySelector(".cc-status");
  if (!line || line.dataset.on) return;
  line.dataset.on = "1";
  let shown = "";
  const tell = () => {
    let text = "";
    const isLost = !cc.connected || cc.words.error;
    if (cc.setting?.is_watched && cc.words.error) text = cc.words.error;
    else if (!cc.connected) text = "No connection to the flight; it goes on. Trying again.";
    else if (cc.words.error) text = cc.words.error;
    else if (!cc.frame || !cc.setting) text = "The drones get ready";
    else {
      const up = cc.frame.drones.filter((drone) => drone.phase === "flying" || drone.phase === "landing").length;
      const pace = cc.words.speed === 0 ? "paused" : cc.frame.rate.toFixed(1) + " x real time";
      text = `${cc.frame.time.toFixed(1)} s, ${pace}, ${up} of ${cc.frame.drones.length} in the air, ${cc.setting.backend}`;
    }
    line.classList.toggle("cc-lost", !!isLost);
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

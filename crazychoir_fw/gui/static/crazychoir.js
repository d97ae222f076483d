// What all parts of the page share: the live connection, commands, the selection, and keys.
(() => {
  const listeners = {};
  const NUMBERS = 11; // of each drone in a frame, as feed.py packs them
  const PHASES = ["ground", "flying", "landing", "landed", "failed", "stopped"];
  const TRAIL_S = 15;

  const cc = {
    setting: null, frame: null, words: {}, drawings: { drawings: [], saved: [] }, lines: [],
    trails: [], selection: new Set(), connected: false, preview: null, dry: null, ghosts: {}, watch: [],
    height: 1.0, offline: 0,
  };
  window.cc = cc;

  cc.on = (name, listener) => {
    (listeners[name] = listeners[name] || new Set()).add(listener);
    return () => listeners[name].delete(listener);
  };
  cc.emit = (name, data) => { for (const listener of listeners[name] || []) listener(data); };
  cc.isDark = () => document.body.classList.contains("body--dark");
  cc.color = (index) => `hsl(${(index * 137.5 + 205) % 360} 70% ${cc.isDark() ? 62 : 42}%)`;
  cc.markColor = (mark) => mark.color || (mark.drone === null ? "#8c949e" : cc.color(mark.drone));
  cc.ink = (alpha = 1) => (cc.isDark() ? `rgba(235,240,245,${alpha})` : `rgba(20,30,40,${alpha})`);
  const newId = () => Array.from(crypto.getRandomValues(new Uint32Array(4)), (n) => n.toString(16)).join("");

  // ---------------------------------------------------------------- requests

  cc.toast = (text, isGood) => {
    const box = document.getElementById("cc-toasts");
    if (!box) return;
    const line = document.createElement("div");
    line.className = "cc-toast " + (isGood ? "cc-good" : "cc-bad");
    line.setAttribute("role", isGood ? "status" : "alert");
    line.textContent = text;
    line.onclick = () => line.remove();
    box.append(line);
    while (box.children.length > 4) box.firstChild.remove();
    setTimeout(() => line.remove(), isGood ? 4000 : 12000);
  };

  // Who was not heard of is nowhere: pictures leave out what is not a number, as in live frames.
  cc.places = (positions) => positions.map((place) => place ?? [NaN, NaN, NaN]);

  cc.get = async (path) => {
    const response = await fetch(path);
    const answer = await response.json();
    if (!answer.ok) throw new Error(answer.text);
    return answer;
  };

  // The same id with every attempt: the server carries it out once, however often it hears of it.
  cc.post = async (path, body, attempts = 4) => {
    for (let attempt = 1; ; attempt++) {
      try {
        const response = await fetch(path, {
          method: "POST", headers: { "content-type": "application/json" }, body: JSON.stringify(body),
        });
        const text = await response.text();
        try { return JSON.parse(text); } catch { return { ok: false, text }; }
      } catch (error) {
        if (attempt >= attempts) return { ok: false, text: "The page does not reach its server: is `crazychoir gui` still running?" };
        await new Promise((done) => setTimeout(done, 300 * attempt));
      }
    }
  };

  cc.command = async (command) => {
    const answer = await cc.post("/api/command", { id: newId(), command });
    cc.toast(answer.text, answer.ok);
    return answer;
  };

  cc.chosen = () => (cc.selection.size ? [...cc.selection] : null);
  cc.press = (name, drones) => cc.command({ name, drones: drones === undefined ? cc.chosen() : drones });
  cc.stop = () => cc.command({ name: "stop", drones: null });

  cc.draw = async (change, isQuiet) => {
    const answer = await cc.post("/api/drawings", { id: newId(), change });
    if (answer.drawings) { cc.drawings = answer; cc.emit("drawings"); }
    if (!answer.ok || !isQuiet) cc.toast(answer.text, answer.ok);
    return answer;
  };

  cc.select = (name, isOnly) => {
    if (isOnly) cc.selection = new Set([name]);
    else if (!cc.selection.delete(name)) cc.selection.add(name);
    cc.emit("selection");
  };
  cc.selectAll = () => { cc.selection = new Set(); cc.emit("selection"); };

  cc.setWatch = (watch) => {
    cc.watch = watch;
    if (socket && socket.readyState === 1) socket.send(JSON.stringify({ watch }));
  };

  // ---------------------------------------------------------------- live

  const readFrame = (buffer) => {
    const values = new Float32Array(buffer);
    const count = values[3], drones = [], moving = [];
    for (let i = 0; i < count; i++) {
      const at = 4 + i * NUMBERS;
      drones.push({
        position: [values[at], values[at + 1], values[at + 2]],
        quat: [values[at + 3], values[at + 4], values[at + 5], values[at + 6]],
        reference: [values[at + 7], values[at + 8], values[at + 9]],
        phase: PHASES[values[at + 10]],
      });
    }
    for (let at = 4 + count * NUMBERS; at < values.length; at += 7)
      moving.push({ position: values.subarray(at, at + 3), quat: values.subarray(at + 3, at + 7) });
    return { number: values[0], time: values[1], rate: values[2], drones, moving };
  };

  const keepTrail = (frame) => {
    const last = cc.trails[cc.trails.length - 1];
    if (last && frame.time < last.time) cc.trails = cc.trails.filter((point) => point.time <= frame.time);
    if (!last || frame.time - last.time >= 0.1 || frame.time < last.time)
      cc.trails.push({ time: frame.time, positions: frame.drones.map((drone) => drone.position) });
    while (cc.trails.length && cc.trails[0].time < frame.time - TRAIL_S) cc.trails.shift();
  };

  const loadSetting = async () => {
    for (;;) {
      try {
        const setting = await cc.get("/api/setting");
        if (setting.ready) {
          cc.setting = setting;
          cc.height = setting.height;
          cc.trails = setting.trail.times.map((time, k) => ({ time, positions: cc.places(setting.trail.positions[k]) }));
          cc.emit("setting");
          return;
        }
        if (setting.error) cc.emit("words", { error: setting.error });
      } catch { /* asked again */ }
      await new Promise((done) => setTimeout(done, 500));
    }
  };

  cc.loadDrawings = async () => {
    try { cc.drawings = await cc.get("/api/drawings"); cc.emit("drawings"); } catch { /* told again */ }
  };

  let socket = null;
  const connect = () => {
    const scheme = location.protocol === "https:" ? "wss:" : "ws:";
    socket = new WebSocket(`${scheme}//${location.host}/api/live`);
    socket.binaryType = "arraybuffer";
    socket.onopen = () => {
      cc.connected = true;
      cc.emit("connection");
      if (cc.watch.length) cc.setWatch(cc.watch);
      if (!cc.setting) loadSetting();
    };
    socket.onmessage = (event) => {
      if (event.data instanceof ArrayBuffer) {
        cc.frame = readFrame(event.data);
        if (cc.setting) { keepTrail(cc.frame); cc.emit("frame", cc.frame); }
        return;
      }
      const words = JSON.parse(event.data);
      if (words.plot) cc.emit("plot", words.plot);
      if (words.cards || words.branches) {
        const branch = cc.words.branch;
        cc.words = { ...cc.words, ...words };
        if (words.lines && words.lines.length) {
          const last = cc.lines.length ? cc.lines[cc.lines.length - 1].number : 0;
          cc.lines.push(...words.lines.filter((line) => line.number > last));
          if (cc.lines.length > 1000) cc.lines.splice(0, cc.lines.length - 1000);
          cc.emit("lines");
        }
        if (words.drawings !== undefined && words.drawings !== cc.drawings.version) cc.loadDrawings();
        if (branch !== undefined && branch !== words.branch) { cc.trails = []; cc.emit("branch"); }
        cc.emit("words", cc.words);
      }
    };
    socket.onclose = () => {
      cc.connected = false;
      cc.emit("connection");
      setTimeout(connect, 700);
    };
  };

  // ---------------------------------------------------------------- keys

  const isTyping = (target) => target.closest && target.closest("input, textarea, select, [contenteditable]");
  document.addEventListener("keydown", (event) => {
    if (event.repeat || cc.setting?.is_watched) return;
    if (event.key === "Escape") {
      if (!document.querySelector(".q-menu, .q-dialog__inner")) { event.preventDefault(); cc.stop(); }
    } else if (!isTyping(event.target) && !event.ctrlKey && !event.metaKey && !event.altKey) {
      if (event.key === "t") cc.press("takeoff");
      else if (event.key === "l") cc.press("land");
      else if (event.key >= "1" && event.key <= "7") cc.emit("tab", Number(event.key) - 1);
    }
  }, true);

  // Without a graphics card each picture takes processor time, on a small machine from the flight itself.
  let isSlow = null;
  cc.isSlow = () => {
    if (isSlow === null) {
      const gl = document.createElement("canvas").getContext("webgl");
      const about = gl && gl.getExtension("WEBGL_debug_renderer_info");
      isSlow = !gl || !!(about && /swiftshader|llvmpipe|software|basic render/i.test(gl.getParameter(about.UNMASKED_RENDERER_WEBGL)));
      gl?.getExtension("WEBGL_lose_context")?.loseContext();
    }
    return isSlow;
  };
  const SLOW_MS = 500, SLOWEST_MS = 1500, SLOW_SHARE = 0.05; // between two pictures, and part of the time for each

  // One watch over the pictures of all tabs: they draw when something changed, and only those that are seen. What a
  // person does shows at once; on a slow machine the rest of all pictures comes together, twice a second at most.
  cc.drawer = (element, draw, least = 0) => { // at most every so many ms
    let isDirty = true, isSeen = true, last = -Infinity, slow = SLOW_MS;
    const observer = new IntersectionObserver((entries) => { isSeen = entries[entries.length - 1].isIntersecting; mark(true); });
    let handle = 0, timer = 0, isOver = false;
    const tick = () => {
      handle = 0;
      if (!isDirty || !isSeen || document.hidden || isOver) return;
      isDirty = false;
      const begin = performance.now();
      draw();
      last = performance.now();
      slow = SLOW_MS * Math.ceil(Math.min(SLOWEST_MS, Math.max(SLOW_MS, (last - begin) / SLOW_SHARE)) / SLOW_MS);
    };
    // a page on which nothing changes does nothing
    const mark = (isByHand) => {
      isDirty = true;
      if (handle || isOver || !isSeen || document.hidden || (timer && isByHand !== true)) return;
      const now = performance.now();
      const wait = cc.isSlow() && isByHand !== true ? slow - (now % slow) : last + least - now;
      clearTimeout(timer);
      timer = 0;
      if (wait > 4) timer = setTimeout(() => { timer = 0; handle = requestAnimationFrame(tick); }, wait);
      else handle = requestAnimationFrame(tick);
    };
    const wake = () => mark(true);
    document.addEventListener("visibilitychange", wake);
    mark.end = () => {
      isOver = true;
      cancelAnimationFrame(handle);
      clearTimeout(timer);
      observer.disconnect();
      document.removeEventListener("visibilitychange", wake);
    };
    observer.observe(element);
    mark(true);
    return mark;
  };

  // a canvas in pixels of the screen; returns its context and size in CSS pixels
  cc.canvas = (canvas) => {
    const ratio = window.devicePixelRatio || 1, box = canvas.getBoundingClientRect();
    const width = Math.max(1, Math.round(box.width)), height = Math.max(1, Math.round(box.height));
    const wide = Math.round(width * ratio), tall = Math.round(height * ratio);
    if (canvas.width !== wide || canvas.height !== tall) { canvas.width = wide; canvas.height = tall; }
    // without a graphics card it is cheaper not to play one
    const context = canvas.getContext("2d", { willReadFrequently: cc.isSlow() });
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    context.clearRect(0, 0, width, height);
    return { context, width, height };
  };

  connect();
})();

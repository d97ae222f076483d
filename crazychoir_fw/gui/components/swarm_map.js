// The room from above, in metres: to send drones somewhere, and to draw what they shall fly.
export default {
  template: `
    <div class="cc-map">
      <canvas :data-testid="'map-' + mode" :aria-label="label" tabindex="0" role="img"
        @pointerdown="down" @pointermove="move" @pointerup="up" @pointercancel="cancel"
        @wheel.prevent="wheel" @contextmenu.prevent></canvas>
      <div class="cc-map-tools">
        <q-btn dense round flat icon="add" aria-label="Zoom in" @click="zoom(1.25)" />
        <q-btn dense round flat icon="remove" aria-label="Zoom out" @click="zoom(0.8)" />
        <q-btn dense round flat icon="fit_screen" aria-label="Show all" @click="fit" />
      </div>
      <div class="cc-map-where">{{ where }}</div>
    </div>`,
  props: { mode: { type: String, default: "goto" } },
  data: () => ({ where: "" }),
  computed: {
    label() {
      return this.mode === "draw" ? "Canvas: draw a trajectory with mouse or finger" : "Map: click to send drones there";
    },
  },
  mounted() {
    this.canvas = this.$el.querySelector("canvas");
    this.view = { x: 0, y: 0, scale: 60 };
    this.stroke = null;
    this.pointers = new Map();
    this.goal = null;
    this.mark = cc.drawer(this.canvas, () => this.draw());
    this.offs = ["frame", "branch"].map((name) => cc.on(name, () => this.mark()));
    for (const name of ["drawings", "selection"]) this.offs.push(cc.on(name, () => this.mark(true)));
    this.offs.push(cc.on("setting", () => this.fit()));
    // what has left the map is shown again, unless a hand has chosen what is seen
    if (this.mode === "goto") this.offs.push(cc.on("words", () => { if (this.isOutside()) this.fit(); }));
    this.sizes = new ResizeObserver(() => (this.isMoved ? this.mark() : this.fit()));
    this.sizes.observe(this.$el);
    if (cc.setting) this.fit();
  },
  unmounted() {
    this.mark.end();
    this.sizes.disconnect();
    this.offs.forEach((off) => off());
  },
  methods: {
    size() { const box = this.canvas.getBoundingClientRect(); return [box.width, box.height]; },
    toScreen([x, y]) {
      const [w, h] = this.size();
      return [w / 2 + (x - this.view.x) * this.view.scale, h / 2 - (y - this.view.y) * this.view.scale];
    },
    toWorld(event) {
      const box = this.canvas.getBoundingClientRect();
      return [
        this.view.x + (event.clientX - box.left - box.width / 2) / this.view.scale,
        this.view.y - (event.clientY - box.top - box.height / 2) / this.view.scale,
      ];
    },
    fit() {
      const [w, h] = this.size();
      if (w < 2 || h < 2) return;
      let [x0, y0, x1, y1] = [-2, -2, 2, 2]; // as much as the canvas of the original
      const take = ([x, y], pad) => {
        x0 = Math.min(x0, x - pad); x1 = Math.max(x1, x + pad); y0 = Math.min(y0, y - pad); y1 = Math.max(y1, y + pad);
      };
      for (const drone of cc.frame ? cc.frame.drones : []) take(drone.position, 0.5);
      for (const mark of cc.words.marks || []) take(mark.position, 0.4);
      const area = cc.setting && cc.setting.safety_area;
      if (area) { take(area.low, 0.2); take(area.high, 0.2); }
      for (const drawing of cc.drawings.drawings) drawing.points.forEach((point) => take(point, 0.2));
      this.view = { x: (x0 + x1) / 2, y: (y0 + y1) / 2, scale: Math.min(w / (x1 - x0), h / (y1 - y0)) * 0.96 };
      this.isMoved = false;
      this.tell();
      this.mark(true);
    },
    isOutside() {
      const [w, h] = this.size();
      if (w < 2 || h < 2 || this.isMoved || this.pointers.size || !cc.frame) return false;
      return [...cc.frame.drones, ...(cc.words.marks || [])].some(({ position }) => {
        const [x, y] = this.toScreen(position);
        return x < 8 || y < 8 || x > w - 8 || y > h - 24;
      });
    },
    tell() { // for tests, and for whoever measures
      Object.assign(this.canvas.dataset, { x: this.view.x, y: this.view.y, scale: this.view.scale });
    },
    zoom(factor) {
      this.view.scale = Math.min(2000, Math.max(3, this.view.scale * factor));
      this.isMoved = true;
      this.tell();
      this.mark(true);
    },
    wheel(event) {
      const [x, y] = this.toWorld(event);
      const factor = Math.exp(-event.deltaY * 0.0015);
      this.zoom(factor);
      const [x2, y2] = this.toWorld(event);
      this.view.x += x - x2; this.view.y += y - y2;
      this.tell();
    },
    down(event) {
      if (this.pointers.size === 0 && (event.button === 1 || event.button === 2)) {
        this.panning = this.toWorld(event);
      } else if (this.pointers.size === 1) { // a second finger: no drawing, the map moves
        this.stroke = null; this.tapped = null;
      } else if (this.mode === "draw") {
        this.stroke = { start: event.timeStamp, points: [[...this.toWorld(event), 0]] };
      } else {
        this.tapped = [event.clientX, event.clientY];
      }
      this.pointers.set(event.pointerId, event);
      this.canvas.setPointerCapture(event.pointerId);
      this.mark(true);
    },
    move(event) {
      const [x, y] = this.toWorld(event);
      this.where = `x ${x.toFixed(2)} m, y ${y.toFixed(2)} m`;
      if (this.panning) {
        this.view.x += this.panning[0] - x; this.view.y += this.panning[1] - y;
        this.isMoved = true; this.tell(); this.mark(true);
      } else if (this.pointers.size === 2 && this.pointers.has(event.pointerId)) {
        const [first, second] = [...this.pointers.values()];
        const other = first.pointerId === event.pointerId ? second : first;
        const before = this.pointers.get(event.pointerId);
        const far = (a, b) => Math.hypot(a.clientX - b.clientX, a.clientY - b.clientY);
        this.view.x -= (event.clientX - before.clientX) / 2 / this.view.scale;
        this.view.y += (event.clientY - before.clientY) / 2 / this.view.scale;
        this.zoom(far(event, other) / Math.max(1, far(before, other)));
      } else if (this.stroke) {
        const events = event.getCoalescedEvents ? event.getCoalescedEvents() : [];
        for (const one of events.length ? events : [event]) this.sample(one);
        this.mark(true);
      }
      if (this.pointers.has(event.pointerId)) this.pointers.set(event.pointerId, event);
    },
    sample(event) {
      const points = this.stroke.points, last = points[points.length - 1];
      const time = Math.max(last[2], (event.timeStamp - this.stroke.start) / 1000);
      const [x, y] = this.toWorld(event);
      if (points.length < 20000 && (x !== last[0] || y !== last[1])) points.push([x, y, time]);
    },
    async up(event) {
      this.pointers.delete(event.pointerId);
      if (this.panning) { this.panning = null; return; }
      if (this.stroke) {
        this.sample(event); // where the pen was lifted is part of the drawing
        const stroke = this.stroke;
        this.stroke = null;
        if (stroke.points.length >= 2) await cc.draw({ action: "add", points: stroke.points, height: cc.height }, true);
        this.mark(true);
      } else if (this.tapped && Math.hypot(event.clientX - this.tapped[0], event.clientY - this.tapped[1]) < 8) {
        const [x, y] = this.toWorld(event);
        const drone = this.droneAt(event);
        if (drone !== null) cc.select(drone, !event.shiftKey && !event.ctrlKey && !(cc.selection.size === 1 && cc.selection.has(drone)));
        else {
          this.goal = [x, y, performance.now()];
          cc.command({ name: "goto", drones: cc.chosen(), x, y, z: cc.height });
        }
      }
      this.tapped = null;
    },
    cancel(event) { this.pointers.delete(event.pointerId); this.stroke = this.tapped = this.panning = null; this.mark(true); },
    droneAt(event) {
      const box = this.canvas.getBoundingClientRect();
      let found = null, least = 20;
      (cc.frame ? cc.frame.drones : []).forEach((drone, i) => {
        const [x, y] = this.toScreen(drone.position);
        const far = Math.hypot(x - (event.clientX - box.left), y - (event.clientY - box.top));
        if (far < least) { least = far; found = cc.setting.names[i]; }
      });
      return found;
    },
    line(c, points, color, width = 2, dash = []) {
      if (points.length < 2) return;
      c.strokeStyle = color; c.lineWidth = width; c.setLineDash(dash); c.lineJoin = c.lineCap = "round";
      c.beginPath();
      points.forEach((point, k) => { const [x, y] = this.toScreen(point); if (k) c.lineTo(x, y); else c.moveTo(x, y); });
      c.stroke();
      c.setLineDash([]);
    },
    draw() {
      const { context: c, width, height } = cc.canvas(this.canvas);
      if (!cc.setting || !cc.frame) return;
      this.written = [];
      this.grid(c, width, height);
      for (const thing of cc.setting.obstacles) {
        const [x, y] = this.toScreen(thing.position);
        const s = this.view.scale, [a, b] = thing.size;
        c.fillStyle = cc.ink(0.18); c.strokeStyle = cc.ink(0.45); c.lineWidth = 1;
        c.save();
        c.translate(x, y);
        c.rotate(-2 * Math.atan2(thing.quat[3], thing.quat[0]));
        c.beginPath();
        if (thing.shape === "box") c.rect(-a * s, -b * s, 2 * a * s, 2 * b * s); else c.arc(0, 0, a * s, 0, 7);
        c.fill(); c.stroke();
        c.restore();
      }
      const area = cc.setting.safety_area;
      if (area) {
        const [x0, y0] = this.toScreen([area.low[0], area.high[1]]), [x1, y1] = this.toScreen([area.high[0], area.low[1]]);
        c.strokeStyle = "rgb(220,120,20)"; c.lineWidth = 2; c.setLineDash([8, 5]);
        c.strokeRect(x0, y0, x1 - x0, y1 - y0); c.setLineDash([]);
      }
      for (const [i, j] of cc.setting.graph)
        this.line(c, [cc.frame.drones[i].position, cc.frame.drones[j].position], cc.ink(0.16), 1);
      const names = cc.setting.names;
      names.forEach((name, i) => this.line(c, cc.trails.map((point) => point.positions[i]), cc.color(i), 1.5));
      for (const drawing of cc.drawings.drawings) {
        const color = cc.color(names.indexOf(drawing.drone));
        this.line(c, drawing.points, color, 4);
        const [x, y] = this.toScreen(drawing.points[0]);
        c.fillStyle = color; c.beginPath(); c.arc(x, y, 5, 0, 7); c.fill();
        if (this.mode === "draw") this.write(c, `${drawing.name} (${drawing.drone})`, x + 8, y - 18, "left");
      }
      if (this.mode !== "draw" && cc.dry) cc.dry.parts.forEach((part) => this.line(c, part.path, cc.ink(0.5), 1, [3, 3]));
      this.marks(c);
      if (this.stroke) this.line(c, this.stroke.points, cc.ink(0.9), 4);
      if (this.goal && performance.now() - this.goal[2] < 2500) {
        const [x, y] = this.toScreen(this.goal);
        c.strokeStyle = cc.ink(0.9); c.lineWidth = 2;
        c.beginPath(); c.moveTo(x - 9, y); c.lineTo(x + 9, y); c.moveTo(x, y - 9); c.lineTo(x, y + 9); c.stroke();
      }
      this.drones(c);
    },
    write(c, text, x, y, align) { // where nothing is written yet
      c.font = "12px system-ui, sans-serif"; c.textAlign = align; c.textBaseline = "top";
      const wide = c.measureText(text).width, left = align === "center" ? x - wide / 2 : x;
      const box = [left - 2, y - 1, left + wide + 2, y + 14];
      if (this.written.some((one) => box[0] < one[2] && one[0] < box[2] && box[1] < one[3] && one[1] < box[3])) return;
      this.written.push(box);
      c.strokeStyle = cc.isDark() ? "rgba(20,24,29,0.8)" : "rgba(255,255,255,0.8)"; c.lineWidth = 3; // legible over curves
      c.lineJoin = "round";
      c.strokeText(text, x, y);
      c.fillText(text, x, y);
      c.textBaseline = "alphabetic";
    },
    grid(c, width, height) {
      c.lineWidth = 1; c.font = "11px system-ui, sans-serif";
      const across = width / this.view.scale / 2, up = height / this.view.scale / 2;
      const step = this.view.scale > 24 ? 0.5 : this.view.scale > 10 ? 1 : 5, label = step === 5 ? 5 : 1;
      const lines = (low, high, put) => {
        for (let k = Math.ceil(low / step); k * step <= high; k++) put(k * step, Number.isInteger(k * step / label));
      };
      lines(this.view.x - across, this.view.x + across, (x, isMetre) => {
        const [px] = this.toScreen([x, 0]);
        c.strokeStyle = cc.ink(x === 0 ? 0.5 : isMetre ? 0.17 : 0.07);
        c.beginPath(); c.moveTo(px, 0); c.lineTo(px, height); c.stroke();
        c.fillStyle = cc.ink(0.6); c.textAlign = "center"; c.textBaseline = "bottom";
        if (isMetre && px > 40) c.fillText(`${x} m`, px, height - 2);
      });
      lines(this.view.y - up, this.view.y + up, (y, isMetre) => {
        const [, py] = this.toScreen([0, y]);
        c.strokeStyle = cc.ink(y === 0 ? 0.5 : isMetre ? 0.17 : 0.07);
        c.beginPath(); c.moveTo(0, py); c.lineTo(width, py); c.stroke();
        c.fillStyle = cc.ink(0.6); c.textAlign = "left"; c.textBaseline = "middle";
        if (isMetre && py < height - 20) c.fillText(`${y} m`, 3, py);
      });
      c.textBaseline = "alphabetic";
    },
    marks(c) { // tasks are disks of the color of whoever does them
      for (const mark of cc.words.marks || []) {
        const color = cc.markColor(mark), [x, y] = this.toScreen(mark.position);
        if (mark.link) this.line(c, [mark.position, mark.link], color, 1, [4, 4]);
        c.fillStyle = color; c.strokeStyle = cc.ink(0.6); c.lineWidth = 1; c.globalAlpha = 0.55;
        c.beginPath(); c.arc(x, y, 9, 0, 7); c.fill(); c.globalAlpha = 1; c.stroke();
        c.fillStyle = cc.ink(0.9);
        this.write(c, mark.label, x, y + 11, "center");
      }
    },
    drones(c) {
      const many = cc.frame.drones.length > 12;
      cc.frame.drones.forEach((drone, i) => {
        const name = cc.setting.names[i], color = drone.phase === "failed" ? "rgb(220,40,40)" : cc.color(i);
        const [x, y] = this.toScreen(drone.position);
        if (Number.isFinite(drone.reference[0])) {
          const [rx, ry] = this.toScreen(drone.reference);
          c.strokeStyle = color; c.lineWidth = 1.5;
          c.beginPath(); c.arc(rx, ry, 5, 0, 7); c.moveTo(rx, ry); c.lineTo(x, y); c.stroke();
        }
        const [qx, qy, qz, qw] = drone.quat;
        const yaw = Math.atan2(2 * (qw * qz + qx * qy), 1 - 2 * (qy * qy + qz * qz));
        c.fillStyle = color; c.strokeStyle = cc.isDark() ? "#111" : "#fff"; c.lineWidth = 1.5;
        c.save();
        c.translate(x, y); c.rotate(-yaw);
        c.beginPath(); c.moveTo(15, 0); c.lineTo(-11, 10); c.lineTo(-6, 0); c.lineTo(-11, -10); c.closePath(); c.fill(); c.stroke();
        c.restore();
        if (cc.selection.has(name)) {
          c.strokeStyle = cc.ink(0.9); c.lineWidth = 2; c.beginPath(); c.arc(x, y, 18, 0, 7); c.stroke();
        }
        if (!many || cc.selection.has(name)) {
          c.fillStyle = cc.ink(0.85);
          this.write(c, name, x, y + 18, "center");
        }
      });
    },
  },
};

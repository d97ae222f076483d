// Live picture of the room: drones with attitude, trails, references, who talks to whom, obstacles, the other branch.
import { THREE, OrbitControls, CSS2DRenderer, CSS2DObject } from "nicegui-scene";

const MOST_LABELS = 40;
const shapes = { // by half sizes (m), as MuJoCo has them
  box: (a, b, c) => new THREE.BoxGeometry(2 * a, 2 * b, 2 * c),
  plane: (a, b) => new THREE.PlaneGeometry(2 * a, 2 * b),
  sphere: (a) => new THREE.SphereGeometry(a, 24, 16),
  ellipsoid: (a, b, c) => new THREE.SphereGeometry(1, 24, 16).scale(a, b, c),
  cylinder: (a, b) => new THREE.CylinderGeometry(a, a, 2 * b, 24).rotateX(Math.PI / 2),
  capsule: (a, b) => new THREE.CapsuleGeometry(a, 2 * b, 8, 16).rotateX(Math.PI / 2),
  mesh: (a, b, c, corners) => {
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", new THREE.Float32BufferAttribute(corners, 3));
    geometry.computeVertexNormals();
    return geometry;
  },
};

export default {
  template: `
    <div class="cc-view">
      <canvas data-testid="view" aria-label="Drones in the room, live" role="img"></canvas>
      <div class="cc-view-labels"></div>
      <div class="cc-view-tools">
        <q-toggle dense v-for="name in Object.keys(show)" :key="name" v-model="show[name]" :label="name" @update:model-value="mark && mark(true)" />
        <q-btn dense flat icon="center_focus_strong" aria-label="Show all drones" @click="look" />
      </div>
      <div v-if="problem" class="cc-view-problem">{{ problem }}</div>
    </div>`,
  data: () => ({ show: { names: true, trails: true, references: true, graph: true, obstacles: true, axes: true, curves: true, follow: false }, problem: "" }),
  mounted() {
    this.canvas = this.$el.querySelector("canvas");
    try {
      this.renderer = new THREE.WebGLRenderer({ canvas: this.canvas, antialias: !cc.isSlow(), alpha: false });
    } catch {
      this.problem = "This browser draws no 3-D pictures (WebGL is off); the map on the tab Fly shows the drones.";
      return;
    }
    this.three = {};
    this.sharpness = cc.isSlow() ? 0.75 : 1.5;
    const scene = (this.three.scene = new THREE.Scene());
    const camera = (this.three.camera = new THREE.PerspectiveCamera(45, 1, 0.05, 300));
    camera.up.set(0, 0, 1);
    this.three.controls = new OrbitControls(camera, this.canvas);
    this.three.controls.addEventListener("change", () => this.mark && this.mark(true));
    scene.add(new THREE.HemisphereLight(0xffffff, 0x8899aa, 2.6));
    const sun = new THREE.DirectionalLight(0xffffff, 1.4);
    sun.position.set(3, -4, 8);
    scene.add(sun);
    this.labels = new CSS2DRenderer({ element: this.$el.querySelector(".cc-view-labels") });
    this.mark = cc.drawer(this.canvas, () => this.draw());
    this.offs = [cc.on("frame", () => this.mark()), cc.on("setting", () => this.build()), cc.on("branch", () => this.mark()),
      cc.on("words", () => { if (JSON.stringify(cc.words.marks || []) !== this.marked) this.mark(); })];
    this.sizes = new ResizeObserver(() => this.mark());
    this.sizes.observe(this.$el);
    if (cc.setting && cc.frame) this.build();
  },
  unmounted() {
    if (!this.mark) return;
    this.mark.end();
    this.sizes.disconnect();
    this.offs.forEach((off) => off());
    this.renderer.dispose();
  },
  methods: {
    build() {
      if (!cc.frame) { setTimeout(() => this.build(), 100); return; }
      const scene = this.three.scene, count = cc.setting.names.length;
      if (this.three.room) { scene.remove(this.three.room); this.curvesShown = undefined; }
      const room = (this.three.room = new THREE.Group());
      scene.add(room);
      const grid = (this.three.grid = new THREE.GridHelper(20, 20));
      grid.rotation.x = Math.PI / 2;
      grid.position.z = 0.005; // over mats on the floor
      grid.material.transparent = true;
      grid.material.opacity = 0.35;
      room.add(grid);
      room.add((this.three.axes = this.axes()));
      room.add((this.three.curves = new THREE.Group()));
      // one body of many: an arm cross with four rotors, nose along x
      const parts = this.body();
      this.three.bodies = parts.map(({ geometry, isAccent }) => {
        const mesh = new THREE.InstancedMesh(geometry, new THREE.MeshLambertMaterial({ color: 0xffffff }), count);
        mesh.frustumCulled = false;
        for (let i = 0; i < count; i++) mesh.setColorAt(i, isAccent ? this.colorOf(i) : new THREE.Color(0x7a8694));
        room.add(mesh);
        return mesh;
      });
      this.three.ghosts = new THREE.InstancedMesh(
        new THREE.SphereGeometry(0.03, 10, 6), new THREE.MeshBasicMaterial({ color: 0xffffff, transparent: true, opacity: 0.6 }), count);
      this.three.ghosts.frustumCulled = false;
      for (let i = 0; i < count; i++) this.three.ghosts.setColorAt(i, this.colorOf(i));
      room.add(this.three.ghosts);
      this.three.trails = this.lines(40000, true);
      this.three.graph = this.lines(2 * Math.max(1, cc.setting.graph.length), false);
      this.three.others = this.lines(40000, true);
      this.three.others.material.opacity = 0.35;
      room.add(this.three.trails, this.three.graph, this.three.others);
      this.three.obstacles = new THREE.Group();
      this.three.moving = []; // bodies that frames place
      for (const thing of cc.setting.obstacles) {
        const [r, g, b, alpha] = thing.color;
        const mesh = new THREE.Mesh(shapes[thing.shape](...thing.size, thing.corners), new THREE.MeshLambertMaterial({
          color: new THREE.Color().setRGB(r, g, b, THREE.SRGBColorSpace), transparent: alpha < 1, opacity: alpha }));
        const [w, x, y, z] = thing.quat;
        mesh.position.set(...thing.position);
        mesh.quaternion.set(x, y, z, w);
        if (thing.body !== null && !this.three.moving[thing.body]) this.three.obstacles.add((this.three.moving[thing.body] = new THREE.Group()));
        (thing.body === null ? this.three.obstacles : this.three.moving[thing.body]).add(mesh);
      }
      const area = cc.setting.safety_area;
      if (area) {
        const box = new THREE.Box3(new THREE.Vector3(...area.low), new THREE.Vector3(...area.high));
        this.three.obstacles.add(new THREE.Box3Helper(box, 0xdd7714));
      }
      room.add(this.three.obstacles);
      this.three.marks = new THREE.Group();
      this.marked = "";
      room.add(this.three.marks);
      this.three.names = cc.setting.names.slice(0, MOST_LABELS).map((name) => {
        const text = document.createElement("div");
        text.className = "cc-label";
        text.textContent = name;
        text.style.pointerEvents = "auto";
        text.onclick = (event) => cc.select(name, !event.shiftKey);
        const label = new CSS2DObject(text);
        room.add(label);
        return label;
      });
      this.look();
    },
    axes() { // red x, green y, blue z from the origin, and numbers along the floor (m)
      const group = new THREE.Group();
      const label = (text, x, y, z) => {
        const element = document.createElement("div");
        element.className = "cc-axis";
        element.textContent = text;
        const one = new CSS2DObject(element);
        one.position.set(x, y, z);
        group.add(one);
      };
      [["x", 0xd33a3a], ["y", 0x2f9e44], ["z", 0x3d7fe0]].forEach(([name, color], k) => {
        const end = new THREE.Vector3().setComponent(k, 1.0);
        group.add(new THREE.ArrowHelper(end, new THREE.Vector3(0, 0, 0.01), 1.0, color, 0.08, 0.05));
        label(name, ...end.clone().multiplyScalar(1.08).toArray());
      });
      for (const meters of [-4, -3, -2, -1, 2, 3, 4]) { label(`${meters} m`, meters, 0, 0); label(`${meters} m`, 0, meters, 0); }
      return group;
    },
    putCurves() { // what the preview has made of the drawings, and the drawings that have no curve yet
      const parts = cc.preview ? cc.preview.parts.map((part) => ({ drone: part.drone, points: part.position }))
        : cc.drawings.drawings.map((drawing) => ({ drone: drawing.drone, points: drawing.points.map(([x, y]) => [x, y, drawing.height]) }));
      const key = cc.preview ? cc.preview.key : `drawn ${cc.drawings.version}`;
      if (key === this.curvesShown) return;
      this.curvesShown = key;
      this.three.curves.traverse((thing) => { thing.geometry?.dispose(); thing.material?.dispose(); });
      this.three.curves.clear();
      for (const { drone, points } of parts) {
        const geometry = new THREE.BufferGeometry().setFromPoints(points.map((point) => new THREE.Vector3(...point)));
        const material = new THREE.LineDashedMaterial({ color: this.colorOf(cc.setting.names.indexOf(drone)), dashSize: 0.06, gapSize: 0.04 });
        this.three.curves.add(new THREE.Line(geometry, material).computeLineDistances());
      }
    },
    colorOf(i) {
      const color = new THREE.Color();
      color.setHSL(((i * 137.5 + 205) % 360) / 360, 0.75, 0.48);
      return color;
    },
    body() {
      const arms = [Math.PI / 4, -Math.PI / 4].map((angle) => new THREE.BoxGeometry(0.13, 0.012, 0.008).rotateZ(angle));
      const rotors = [0, 1, 2, 3].map((k) => {
        const angle = Math.PI / 4 + (k * Math.PI) / 2;
        return new THREE.CylinderGeometry(0.024, 0.024, 0.004, 10).rotateX(Math.PI / 2)
          .translate(0.065 * Math.cos(angle), 0.065 * Math.sin(angle), 0.012);
      });
      const hull = new THREE.BoxGeometry(0.05, 0.03, 0.016);
      const nose = new THREE.ConeGeometry(0.012, 0.03, 8).rotateZ(-Math.PI / 2).translate(0.04, 0, 0.004);
      return [
        { geometry: merged([...arms, hull]), isAccent: false },
        { geometry: merged([...rotors, nose]), isAccent: true },
      ];
    },
    lines(most, hasColors) {
      const geometry = new THREE.BufferGeometry();
      geometry.setAttribute("position", new THREE.BufferAttribute(new Float32Array(most * 3), 3));
      if (hasColors) geometry.setAttribute("color", new THREE.BufferAttribute(new Float32Array(most * 3), 3));
      geometry.setDrawRange(0, 0);
      const material = new THREE.LineBasicMaterial({ vertexColors: hasColors, transparent: true, opacity: hasColors ? 0.9 : 0.35,
        color: hasColors ? 0xffffff : 0x8899aa });
      const lines = new THREE.LineSegments(geometry, material);
      lines.frustumCulled = false;
      return lines;
    },
    look() {
      if (!cc.frame || !this.three) return;
      const box = new THREE.Box3();
      cc.frame.drones.forEach((drone) => box.expandByPoint(new THREE.Vector3(...drone.position)));
      cc.drawings.drawings.forEach((drawing) => drawing.points.forEach(([x, y]) => box.expandByPoint(new THREE.Vector3(x, y, drawing.height))));
      (cc.words.marks || []).forEach((mark) => box.expandByPoint(new THREE.Vector3(...mark.position)));
      box.expandByPoint(new THREE.Vector3(box.min.x, box.min.y, 1.0));
      const middle = box.getCenter(new THREE.Vector3()), away = 1.7 + 0.75 * box.getSize(new THREE.Vector3()).length();
      this.three.controls.target.set(middle.x, middle.y, 0.5);
      this.three.camera.position.set(middle.x + 0.45 * away, middle.y - 0.9 * away, 0.5 + 0.55 * away);
      this.three.controls.update();
      this.mark();
    },
    draw() {
      if (!this.three || !this.three.bodies || !cc.frame) return;
      const { scene, camera } = this.three, frame = cc.frame, big = 1.6 + Math.min(1.0, frame.drones.length / 30);
      const box = this.$el.getBoundingClientRect();
      const width = Math.max(1, Math.round(box.width)), height = Math.max(1, Math.round(box.height));
      if (this.width !== width || this.height !== height) {
        this.width = width; this.height = height;
        this.renderer.setPixelRatio(Math.min(this.sharpness, window.devicePixelRatio || 1));
        this.renderer.setSize(width, height, false);
        this.labels.setSize(width, height);
        camera.aspect = width / height;
        camera.updateProjectionMatrix();
      }
      this.follow(frame);
      const matrix = new THREE.Matrix4(), place = new THREE.Vector3(), turn = new THREE.Quaternion();
      const one = new THREE.Vector3(big, big, big), none = new THREE.Vector3(0, 0, 0);
      frame.drones.forEach((drone, i) => {
        place.set(...drone.position); turn.set(...drone.quat);
        matrix.compose(place, turn, one);
        this.three.bodies.forEach((mesh) => mesh.setMatrixAt(i, matrix));
        const isTold = this.show.references && Number.isFinite(drone.reference[0]);
        if (isTold) place.set(...drone.reference);
        matrix.compose(place, turn, isTold ? one : none);
        this.three.ghosts.setMatrixAt(i, matrix);
        const label = this.three.names[i];
        if (label) { label.position.set(drone.position[0], drone.position[1], drone.position[2] + 0.09 * big); label.visible = this.show.names; }
      });
      this.three.bodies.forEach((mesh) => { mesh.instanceMatrix.needsUpdate = true; });
      this.three.ghosts.instanceMatrix.needsUpdate = true;
      this.three.obstacles.visible = this.show.obstacles;
      this.putCurves();
      this.three.curves.visible = this.show.curves;
      this.three.axes.visible = this.show.axes;
      this.three.axes.traverse((thing) => { if (thing.isCSS2DObject) thing.visible = this.show.axes; });
      this.three.moving.forEach((body, k) => { body.position.fromArray(frame.moving[k].position); body.quaternion.fromArray(frame.moving[k].quat); });
      this.putMarks();
      // trails grow ten times a second, and are the most work
      const newest = `${cc.trails.length} ${cc.trails.length ? cc.trails[cc.trails.length - 1].time : 0} ${this.show.trails} ${Object.keys(cc.ghosts)}`;
      if (newest !== this.newest) {
        this.newest = newest;
        this.put(this.three.trails, this.show.trails ? this.segments(cc.trails.map((point) => point.positions)) : []);
        if (Object.keys(cc.ghosts).length || this.three.others.geometry.drawRange.count) this.put(this.three.others, Object.values(cc.ghosts).flatMap((ghost) => this.segments(ghost.positions)));
      }
      this.put(this.three.graph, this.show.graph ? cc.setting.graph.flatMap(([i, j]) => [[i, frame.drones[i].position], [j, frame.drones[j].position]]) : []);
      this.renderer.setClearColor(cc.isDark() ? 0x14181d : 0xf4f6f8);
      this.renderer.render(scene, camera);
      if (this.show.names || this.hadNames || this.show.axes || this.hadAxes || this.three.marks.children.length) {
        this.spread(camera, width, height);
        this.labels.render(scene, camera);
      }
      this.hadNames = this.show.names;
      this.hadAxes = this.show.axes;
      if (cc.isSlow()) { // waits until it is drawn, so that its cost is known
        const gl = this.renderer.getContext();
        gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(4));
      }
    },
    follow(frame) { // the camera goes along with the drones that are chosen, or with all
      const places = frame.drones.filter((drone, i) => !cc.selection.size || cc.selection.has(cc.setting.names[i]))
        .map((drone) => new THREE.Vector3(...drone.position)).filter((place) => Number.isFinite(place.x));
      const whom = [...cc.selection].join(), middle = new THREE.Vector3();
      places.forEach((place) => middle.addScaledVector(place, 1 / places.length));
      if (this.show.follow && places.length && this.followed?.whom === whom) {
        const way = middle.clone().sub(this.followed.middle);
        this.three.controls.target.add(way);
        this.three.camera.position.add(way);
      }
      this.followed = { whom, middle };
    },
    spread(camera, width, height) { // of labels over each other the nearest is shown
      const labels = [...this.three.names.filter((label) => label.visible), ...this.three.marks.children.filter((thing) => thing.isCSS2DObject)];
      const boxes = [], place = new THREE.Vector3();
      const far = new Map(labels.map((label) => [label, camera.position.distanceToSquared(label.position)]));
      for (const label of labels.sort((a, b) => far.get(a) - far.get(b))) {
        place.copy(label.position).project(camera);
        const x = (place.x * width) / 2, y = (place.y * height) / 2, half = 4 + 3.4 * label.element.textContent.length;
        label.visible = !boxes.some((one) => Math.abs(one.x - x) < one.half + half && Math.abs(one.y - y) < 17);
        if (label.visible) boxes.push({ x, y, half });
      }
    },
    putMarks() {
      const all = cc.words.marks || [], text = JSON.stringify(all);
      if (text === this.marked) return;
      this.marked = text;
      this.three.marks.traverse((thing) => { thing.geometry?.dispose(); thing.material?.dispose(); thing.element?.remove(); });
      this.three.marks.clear();
      for (const mark of all) {
        const material = new THREE.MeshBasicMaterial({ color: new THREE.Color().setStyle(cc.markColor(mark).replace(/ (?=\d)/g, ", ")), transparent: true, opacity: 0.6 });
        const isOnFloor = mark.position[2] < 0.01; // tasks lie on the floor, targets hang in the air
        const shape = isOnFloor ? new THREE.CylinderGeometry(0.1, 0.1, 0.01, 16).rotateX(Math.PI / 2) : new THREE.SphereGeometry(0.06, 12, 8);
        const mesh = new THREE.Mesh(shape, material);
        mesh.position.set(mark.position[0], mark.position[1], mark.position[2] + 0.01);
        this.three.marks.add(mesh);
        if (mark.link) {
          const points = [mark.position, mark.link].map(([x, y, z]) => new THREE.Vector3(x, y, z + 0.01));
          this.three.marks.add(new THREE.Line(new THREE.BufferGeometry().setFromPoints(points), new THREE.LineBasicMaterial({ color: material.color, transparent: true, opacity: 0.6 })));
        }
        const name = document.createElement("div");
        name.className = "cc-label";
        name.textContent = mark.label;
        const label = new CSS2DObject(name);
        label.position.set(mark.position[0], mark.position[1], mark.position[2] + 0.12);
        this.three.marks.add(label);
      }
      this.hadNames = true; // the labels are placed once
    },
    segments(rows) {
      const found = [];
      for (let k = 1; k < rows.length; k++)
        for (let i = 0; i < rows[k].length; i++) found.push([i, rows[k - 1][i]], [i, rows[k][i]]);
      return found;
    },
    put(lines, points) {
      const position = lines.geometry.attributes.position, color = lines.geometry.attributes.color;
      const count = Math.min(points.length, position.count), first = points.length - count;
      this.palette = this.palette || {};
      for (let k = 0; k < count; k++) {
        const [i, place] = points[first + k];
        position.setXYZ(k, place[0], place[1], place[2]);
        if (color) {
          const paint = (this.palette[i] = this.palette[i] || this.colorOf(i));
          color.setXYZ(k, paint.r, paint.g, paint.b);
        }
      }
      for (const attribute of color ? [position, color] : [position]) {
        attribute.clearUpdateRanges(); // what is not drawn is not sent to the graphics card
        attribute.addUpdateRange(0, count * 3);
        attribute.needsUpdate = count > 0;
      }
      lines.geometry.setDrawRange(0, count);
    },
  },
};

function merged(geometries) {
  const positions = [], normals = [];
  for (const geometry of geometries) {
    const flat = geometry.toNonIndexed();
    positions.push(...flat.attributes.position.array);
    normals.push(...flat.attributes.normal.array);
  }
  const result = new THREE.BufferGeometry();
  result.setAttribute("position", new THREE.Float32BufferAttribute(positions, 3));
  result.setAttribute("normal", new THREE.Float32BufferAttribute(normals, 3));
  return result;
}

// What would be flown: how drawings become curves, what these ask for, and FLY.
import { plot, endPlots } from "/static/plot.js";

export default {
  template: `
    <div class="cc-preview">
      <div class="cc-panel">
        <q-btn-toggle v-model="method" spread no-caps :options="[{ label: 'Spline', value: 'spline' }, { label: 'Minimum snap', value: 'minimum_snap' }]" @update:model-value="soon" />
        <label class="cc-slider">Interpolation distance: {{ distance.toFixed(2) }} m
          <q-slider v-model="distance" :min="0.01" :max="1" :step="0.01" aria-label="Interpolation distance" @update:model-value="soon" /></label>
        <label class="cc-slider">Time scale: {{ scale.toFixed(1) }} x as long as it was drawn
          <q-slider v-model="scale" :min="0.5" :max="10" :step="0.1" aria-label="Time scale" @update:model-value="soon" /></label>
        <q-toggle v-model="stretch" label="Fly more slowly where limits would be broken" @update:model-value="soon" />
        <div class="cc-row">
          <q-btn outline icon="visibility" label="PREVIEW" @click="make" />
          <q-btn outline icon="science" label="DRY RUN" :disable="!preview" :loading="isRunning" :percentage="100 * dryShare" @click="dryRun"><q-tooltip>Flies the curves on point masses, not here</q-tooltip></q-btn>
          <q-btn color="positive" icon="send" label="FLY" :disable="!preview" @click="fly" />
        </div>
        <div v-if="problem" class="cc-bad cc-note" role="alert">{{ problem }}</div>
        <template v-if="preview">
          <div class="cc-note" data-testid="preview-facts"><b>{{ preview.duration.toFixed(1) }} s</b>, {{ preview.parts.length }} drones<span v-if="preview.least_distance !== null">, never nearer to each other than {{ preview.least_distance.toFixed(2) }} m</span>.</div>
          <div v-for="part in preview.parts" :key="part.drone" class="cc-note">{{ part.drone }} flies '{{ part.drawing }}': at most {{ (100 * part.deviation).toFixed(0) }} cm beside the drawing<span v-if="part.slowdown > 1.005">, {{ part.slowdown.toFixed(2) }} x as slowly as asked for, to keep within limits</span>.</div>
          <div v-for="text in preview.warnings" :key="text" class="cc-bad cc-note">{{ text }}</div>
          <div v-if="!preview.warnings.length" class="cc-good cc-note">All limits of the platform are kept.</div>
          <div v-if="dry" class="cc-note" data-testid="dry">Dry run: <span v-for="part in dry.parts" :key="part.drone">{{ part.drone }} off by {{ (100 * part.rms).toFixed(1) }} cm RMS, {{ (100 * part.largest).toFixed(1) }} cm at most. </span></div>
        </template>
        <div v-if="flying" class="cc-note" data-testid="flying">In the air: '{{ flying.name }}', {{ flying.phase }}</div>
      </div>
      <div class="cc-plots">
        <q-select v-if="preview && preview.parts.length > 1" dense v-model="chosen" :options="preview.parts.map((part) => part.drone)" label="Drone" @update:model-value="mark" />
        <div ref="path" class="cc-plot" role="img" aria-label="Curves from above"></div>
        <div ref="position" class="cc-plot" role="img" aria-label="Position over time"></div>
        <div ref="velocity" class="cc-plot" role="img" aria-label="Velocity over time"></div>
        <div ref="acceleration" class="cc-plot" role="img" aria-label="Acceleration over time"></div>
      </div>
    </div>`,
  data: () => ({ method: "spline", distance: 0.2, scale: 5, stretch: true, preview: null, dry: null, problem: "", chosen: null, isRunning: false, dryShare: 0, flying: null }),
  mounted() {
    this.mark = cc.drawer(this.$refs.position, () => this.draw());
    this.sizes = new ResizeObserver(() => this.mark());
    this.sizes.observe(this.$el);
    this.offs = [
      cc.on("drawings", () => { this.isStale = true; if (this.$el.offsetParent) this.soon(); }),
      cc.on("words", (words) => { this.flying = words.flying; this.dryShare = words.dry_run ?? 0; }),
      cc.on("shown", (tab) => { if (tab === "Preview" && (this.isStale || !this.preview)) this.soon(); this.mark(); }),
    ];
  },
  beforeUnmount() { endPlots(this.$el); },
  unmounted() { this.mark.end(); this.sizes.disconnect(); this.offs.forEach((off) => off()); },
  methods: {
    soon() { clearTimeout(this.timer); this.timer = setTimeout(() => this.make(), 250); },
    async make() {
      clearTimeout(this.timer);
      this.isStale = false;
      if (!cc.drawings.drawings.length) { this.preview = cc.preview = null; this.problem = "Draw something first, on the tab Draw."; this.mark(); return; }
      const answer = await cc.post("/api/preview", { method: this.method, distance: this.distance, time_scale: this.scale, stretch: this.stretch });
      this.problem = answer.ok ? "" : answer.text;
      this.preview = cc.preview = answer.ok ? answer : null;
      this.dry = cc.dry = null;
      if (answer.ok && !answer.parts.some((part) => part.drone === this.chosen)) this.chosen = answer.parts[0].drone;
      this.mark();
    },
    async dryRun() {
      this.isRunning = true;
      const answer = await cc.post("/api/dry_run", { preview: this.preview.key });
      this.isRunning = false;
      this.problem = answer.ok ? "" : answer.text;
      this.dry = cc.dry = answer.ok ? answer : null;
      this.mark();
    },
    fly() { cc.emit("about to fly", { name: "fly", preview: this.preview.key }); },
    draw() {
      const part = this.preview && this.preview.parts.find((one) => one.drone === this.chosen);
      const colors = ["#e0524d", "#3aa655", "#3d7fe0"];
      for (const [name, unit, order] of [["position", "m"], ["velocity", "m/s", "speed"], ["acceleration", "m/s²", "force"]]) {
        const series = !part ? [] : ["x", "y", "z"].map((axis, k) => ({ name: axis, color: colors[k], points: part[name].map((row, at) => [part.times[at], row[k]]) }));
        if (part && order) series.push({ name: "magnitude", color: cc.ink(0.9), points: part[order].map((value, at) => [part.times[at], value]) });
        const limit = part && (name === "velocity" ? part.limits.speed : name === "acceleration" ? part.limits.acceleration : null);
        const spans = part ? part.violations[name === "velocity" ? "speed" : name] || [] : [];
        plot(this.$refs[name], { title: `${name}${part ? " of " + part.drone : ""}`, unit, series, spans, limits: limit ? [{ value: limit, name: `limit ${limit} ${unit}` }] : [] });
      }
      this.drawPath();
    },
    drawPath() {
      const lines = !this.preview ? [] : [
        ...cc.drawings.drawings.map((drawn) => ({ points: drawn.points, color: cc.ink(0.2), width: 6 })),
        ...this.preview.parts.map((part) => ({ points: part.position, color: cc.color(cc.setting.names.indexOf(part.drone)), width: 2 })),
        ...(this.dry ? this.dry.parts : []).map((part) => ({ points: part.path, color: cc.ink(0.9), width: 1, dash: [4, 4] })),
      ];
      const series = lines.map((line) => ({ ...line, points: line.points.map(([x, y]) => [x, y]) }));
      plot(this.$refs.path, { title: "from above: drawn (pale), fitted (dark), dry run (dashes)", series, isMap: true });
    },
  },
};

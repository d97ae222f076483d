// Plots of any log variables of any drones, several variables in one plot, while they fly.
import { plot, endPlots } from "/static/plot.js";

const MOST_S = 30;
const MOST_PLOTS = 6;
export default {
  template: `
    <div class="cc-panel">
      <div class="cc-row">
        <q-select dense use-input input-debounce="0" class="cc-name" label="Add a variable" :options="options" :model-value="null" @filter="filter" @update:model-value="add">
          <template #option="{ itemProps, opt }"><q-item dense v-bind="itemProps"><q-item-section><q-item-label>{{ opt }}</q-item-label>
            <q-item-label caption>{{ about(opt) }}</q-item-label></q-item-section></q-item></template>
        </q-select>
        <q-select dense class="cc-who" label="to" v-model="target" :options="targets" />
        <q-select dense multiple class="cc-who" label="Drones" v-model="drones" :options="names" @update:model-value="tell" />
        <q-btn dense flat :icon="isPaused ? 'play_arrow' : 'pause'" :aria-label="isPaused ? 'Go on with the plots' : 'Pause the plots'" data-testid="pause-plots" @click="pause" />
      </div>
      <div v-if="few" class="cc-hint" data-testid="few-plots">{{ few }}</div>
      <div v-for="(variables, k) in plots" :key="variables[0]" class="cc-live">
        <div class="cc-plot" :data-variable="variables[0]" role="img" :aria-label="'Plot of ' + variables.join(', ')"></div>
        <q-btn dense flat round icon="close" :aria-label="'Remove ' + variables[0]" @click="remove(k)" />
      </div>
      <div v-if="plots.length" class="cc-hint">Wheel: zoom in time; drag: move. PAUSE holds what is shown.</div>
    </div>`,
  data: () => ({ plots: [], drones: [], names: [], options: [], few: "", target: "a new plot", isPaused: false }),
  computed: {
    targets() { return ["a new plot", ...this.plots.map((variables) => variables[0])]; },
  },
  mounted() {
    this.data = {};
    this.mark = cc.drawer(this.$el, () => this.draw(), 250);
    this.offs = [
      cc.on("setting", () => this.begin()), cc.on("plot", (plot) => this.take(plot)), cc.on("branch", () => { this.data = {}; }),
      cc.on("shown", (tab) => { this.isShown = tab === "Watch"; this.tell(); }),
    ];
    this.begin();
  },
  beforeUnmount() { endPlots(this.$el); },
  unmounted() { this.mark.end(); this.offs.forEach((off) => off()); },
  methods: {
    begin() {
      if (!cc.setting) return;
      this.names = cc.setting.names;
      this.few = cc.setting.missing.plots || "";
      if (!this.drones.length) this.drones = this.names.slice(0, 4);
      if (!this.plots.length) {
        const wanted = ["stateEstimate.z", "pm.vbat", "position.z"];
        this.plots = wanted.filter((name) => cc.setting.log_names.includes(name)).slice(0, 2).map((name) => [name]);
      }
      this.tell();
    },
    unit: (name) => (cc.setting?.log_about[name] || ["", ""])[0],
    about(name) { const [unit, text] = cc.setting.log_about[name] || ["", ""]; return unit && unit !== "1" ? `${text} (${unit})` : text; },
    filter(text, update) {
      update(() => {
        const words = text.toLowerCase().split(/\s+/);
        this.options = (cc.setting ? cc.setting.log_names : []).filter((name) => words.every((word) => `${name} ${this.about(name)}`.toLowerCase().includes(word))).slice(0, 200);
      });
    },
    add(name) {
      if (!name || this.plots.some((variables) => variables.includes(name))) return;
      const into = this.plots.find((variables) => variables[0] === this.target);
      if (into) into.push(name);
      else this.plots = [...this.plots, [name]].slice(-MOST_PLOTS);
      this.tell();
    },
    remove(k) {
      endPlots(this.$el.querySelectorAll(".cc-live")[k]);
      if (this.target === this.plots[k][0]) this.target = "a new plot";
      this.plots = this.plots.filter((_, one) => one !== k);
      this.tell();
    },
    pause() { this.isPaused = !this.isPaused; if (!this.isPaused) this.mark(true); },
    tell() {
      const watch = !this.isShown ? [] : this.plots.flat().flatMap((name) => this.drones.map((drone) => [this.names.indexOf(drone), name]));
      cc.setWatch(watch.slice(0, 64));
      this.mark();
    },
    take({ times, rows, names }) {
      names.forEach((name, k) => {
        const points = (this.data[name] = this.data[name] || []);
        times.forEach((time, row) => {
          const last = points.at(-1)?.[0];
          if (time <= last) { if (time > last - 0.5) return; points.length = 0; }
          points.push([time, rows[row][k]]);
        });
        while (points.length && points[0][0] < points.at(-1)[0] - MOST_S) points.shift();
      });
      if (!this.isPaused) this.mark();
    },
    draw() {
      this.$el.querySelectorAll(".cc-plot").forEach((box, at) => {
        const variables = this.plots[at];
        const units = [...new Set(variables.map(this.unit))].filter((unit) => unit && unit !== "1");
        const series = variables.flatMap((variable, v) => this.drones.map((drone) => {
          const i = this.names.indexOf(drone);
          const name = variables.length > 1 ? `${drone} ${variable}` : drone;
          return { name, color: cc.color(i), dash: [null, "dashed", "dotted"][v % 3], points: this.data[`${i}:${variable}`] || [] };
        }));
        plot(box, { title: variables.join(", "), unit: units.join(", "), series, canZoom: true });
      });
    },
  },
};

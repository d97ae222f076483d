// Plots of any log variables of any drones, while they fly.
import { plot, endPlots } from "/static/plot.js";

const MOST_S = 30;
export default {
  template: `
    <div class="cc-panel">
      <div class="cc-row">
        <q-select dense use-input input-debounce="0" class="cc-name" label="Add a variable" :options="options" :model-value="null" @filter="filter" @update:model-value="add" />
        <q-select dense multiple class="cc-who" label="Drones" v-model="drones" :options="names" @update:model-value="tell" />
      </div>
      <div v-if="few" class="cc-hint" data-testid="few-plots">{{ few }}</div>
      <div v-for="variable in variables" :key="variable" class="cc-live">
        <div class="cc-plot" :data-variable="variable" role="img" :aria-label="'Plot of ' + variable"></div>
        <q-btn dense flat round icon="close" :aria-label="'Remove ' + variable" @click="remove(variable)" />
      </div>
    </div>`,
  data: () => ({ variables: [], drones: [], names: [], options: [], few: "" }),
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
      if (!this.variables.length) {
        const wanted = ["stateEstimate.z", "pm.vbat", "position.z"];
        this.variables = wanted.filter((name) => cc.setting.log_names.includes(name)).slice(0, 2);
      }
      this.tell();
    },
    filter(text, update) {
      update(() => {
        const words = text.toLowerCase().split(/\s+/);
        this.options = (cc.setting ? cc.setting.log_names : []).filter((name) => words.every((word) => name.toLowerCase().includes(word))).slice(0, 200);
      });
    },
    add(name) { if (name && !this.variables.includes(name)) { this.variables = [...this.variables, name].slice(-6); this.tell(); } },
    remove(name) { endPlots(this.$el.querySelector(`.cc-live:has([data-variable="${name}"])`)); this.variables = this.variables.filter((one) => one !== name); this.tell(); },
    tell() {
      const watch = !this.isShown ? [] : this.variables.flatMap((name) => this.drones.map((drone) => [this.names.indexOf(drone), name]));
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
      this.mark();
    },
    draw() {
      for (const box of this.$el.querySelectorAll(".cc-plot")) {
        const variable = box.dataset.variable;
        const series = this.drones.map((drone) => {
          const i = this.names.indexOf(drone);
          return { name: drone, color: cc.color(i), points: this.data[`${i}:${variable}`] || [] };
        });
        plot(box, { title: variable, series });
      }
    },
  },
};

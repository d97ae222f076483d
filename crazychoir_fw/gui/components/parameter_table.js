// All parameters of a drone: search, edit; one drone or all.
const COLUMNS = [
  { name: "name", label: "Parameter", field: "name", align: "left", sortable: true },
  { name: "value", label: "Value", field: "value", align: "left" },
  { name: "default", label: "Default", field: "default", align: "right" },
  { name: "unit", label: "Unit", field: "unit", align: "left", sortable: true },
  { name: "description", label: "What it is", field: "description", align: "left", classes: "cc-about" },
];
export default {
  template: `
    <div v-if="missing" class="cc-panel"><div class="cc-note" data-testid="no-parameters">{{ missing }}</div></div>
    <div v-else class="cc-panel">
      <div class="cc-row">
        <q-select dense class="cc-who" label="Drone" v-model="drone" :options="names" @update:model-value="load" />
        <q-input dense class="cc-name" v-model="search" label="Search, for instance: pid kp" clearable autofocus data-testid="search" />
        <q-toggle v-model="isChangedOnly" label="Changed only" data-testid="changed-only" />
        <q-toggle v-model="isForAll" label="Write to all drones" />
        <q-btn dense outline icon="refresh" label="READ" @click="load" />
      </div>
      <div class="cc-hint">{{ note }}</div>
      <q-table class="cc-table" data-testid="parameters" dense flat virtual-scroll hide-bottom :rows-per-page-options="[0]" row-key="name" :columns="columns" :rows="found">
        <template #body-cell-name="{ row }"><q-td :title="row.type"><span :class="{ 'cc-changed': isChanged(row) }">{{ row.name }}</span></q-td></template>
        <template #body-cell-default="{ row }"><q-td class="text-right">
          <q-btn v-if="isChanged(row) && !row.read_only" dense flat no-caps size="sm" icon="undo" :label="text(row.default)" aria-label="Back to the default" @click="set(row, row.default)" />
          <template v-else>{{ text(row.default) }}</template>
        </q-td></template>
        <template #body-cell-value="{ row }"><q-td>
          <template v-if="row.read_only">{{ row.value }}</template>
          <input v-else :value="text(row.value)" :aria-label="row.name" inputmode="decimal" @keydown.enter="$event.target.blur()" @change="write(row, $event)" />
        </q-td></template>
      </q-table>
    </div>`,
  data: () => ({ drone: null, names: [], rows: [], search: "", isForAll: false, isChangedOnly: false, problem: "", missing: "", columns: COLUMNS }),
  computed: {
    found() {
      const words = (this.search || "").toLowerCase().split(/\s+/).filter(Boolean);
      const says = (row) => `${row.name} ${row.description} ${row.unit}`.toLowerCase();
      return this.rows.filter((row) => (!this.isChangedOnly || this.isChanged(row)) && words.every((word) => says(row).includes(word)));
    },
    note() {
      if (this.problem) return this.problem;
      if (!this.rows.length) return "This backend has no parameters: its drones have no onboard software.";
      return `${this.found.length} of ${this.rows.length} parameters, ${this.rows.filter(this.isChanged).length} changed. Enter writes.`;
    },
  },
  mounted() {
    this.offs = [cc.on("setting", () => this.begin()), cc.on("branch", () => this.load())];
    this.begin();
  },
  unmounted() { this.offs.forEach((off) => off()); },
  methods: {
    text: (value) => (value === null ? "" : String(Number(value.toPrecision(7)))),
    isChanged: (row) => !row.read_only && row.default !== null && row.value !== null && row.value !== row.default,
    begin() {
      if (!cc.setting) return;
      this.missing = cc.setting.missing.parameters || "";
      if (this.missing) return;
      this.names = cc.setting.names;
      this.drone = this.drone || this.names[0];
      this.load();
    },
    async load() {
      if (this.missing) return;
      try {
        this.rows = (await cc.get("/api/parameters?drone=" + encodeURIComponent(this.drone))).parameters;
        this.problem = "";
      } catch (error) { this.problem = error.message; }
    },
    async write(row, event) {
      const value = Number(event.target.value);
      if (event.target.value.trim() === "" || !Number.isFinite(value)) {
        cc.toast(`${row.name} is '${event.target.value}', allowed: a number`, false);
      } else await this.set(row, value);
      event.target.value = this.text(row.value);
    },
    async set(row, value) {
      const answer = await cc.command({ name: "set_parameter", parameter: row.name, value, drones: this.isForAll ? null : [this.drone] });
      if (answer.ok) row.value = value;
    },
  },
};

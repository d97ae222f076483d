// The drawings: who flies them, how high; undo, files, the example.
export default {
  template: `
    <div class="cc-panel">
      <div class="cc-row">
        <q-btn dense outline icon="undo" label="UNDO" :disable="!canUndo" @click="change({ action: 'undo' })" />
        <q-btn dense outline icon="delete_sweep" label="CLEAR" :disable="!drawings.length" @click="change({ action: 'delete' })" />
        <q-btn dense outline icon="abc" label="EXAMPLE: LETTERING" @click="change({ action: 'example', name: 'lettering' })" />
      </div>
      <label class="cc-slider">Height of new drawings: {{ height.toFixed(2) }} m
        <q-slider v-model="height" :min="0.1" :max="3" :step="0.05" aria-label="Height of new drawings in metres" @update:model-value="setHeight" />
      </label>
      <div v-for="drawing in drawings" :key="drawing.key" class="cc-drawing" data-testid="drawing">
        <span class="cc-dot" :style="{ background: color(drawing.drone) }"></span>
        <q-input dense class="cc-name" :model-value="drawing.name" aria-label="Name" @change="(name) => rename(drawing, name)" />
        <q-select dense class="cc-who" :model-value="drawing.drone" :options="names" aria-label="Drone" @update:model-value="(drone) => change({ action: 'change', drawing: drawing.key, drone })" />
        <q-input dense class="cc-high" type="number" step="0.1" suffix="m" :model-value="drawing.height" aria-label="Height" @change="(value) => setTall(drawing, value)" />
        <q-btn dense flat icon="download" aria-label="Export as CSV" :href="'/api/drawings/' + drawing.key + '.csv'" download />
        <q-btn dense flat icon="delete" aria-label="Delete" @click="change({ action: 'delete', drawing: drawing.key })" />
      </div>
      <div v-if="!drawings.length" class="cc-hint">Draw on the canvas: press, move, let go. One drawing for each drone; each next one is for the next drone.</div>
      <div class="cc-row">
        <q-input dense class="cc-name" v-model="name" label="Name of the set" />
        <q-btn dense outline icon="save" label="SAVE" @click="change({ action: 'save', name })" />
        <q-btn dense outline icon="upload_file" label="IMPORT CSV" @click="$refs.file.click()" />
        <input ref="file" type="file" accept=".csv,text/csv" multiple hidden @change="take" />
      </div>
      <div v-if="saved.length" class="cc-row">Saved:
        <q-btn v-for="one in saved" :key="one" dense flat no-caps icon="folder_open" :label="one" @click="change({ action: 'load', name: one })" />
      </div>
    </div>`,
  data: () => ({ drawings: [], saved: [], names: [], canUndo: false, height: 1.0, name: "my drawing" }),
  mounted() {
    this.offs = [cc.on("drawings", () => this.update()), cc.on("setting", () => this.update())];
    this.update();
  },
  unmounted() { this.offs.forEach((off) => off()); },
  methods: {
    update() {
      const { drawings, saved, can_undo } = cc.drawings;
      Object.assign(this, { drawings, saved: saved || [], canUndo: can_undo, height: cc.height });
      this.names = cc.setting ? cc.setting.names : [];
    },
    color(drone) { return cc.color(this.names.indexOf(drone)); },
    change: (change) => cc.draw(change, change.action === "change"),
    rename(drawing, name) { cc.draw({ action: "change", drawing: drawing.key, name }, true).then(() => this.update()); },
    setTall(drawing, value) { cc.draw({ action: "change", drawing: drawing.key, height: Number(value) }, true).then(() => this.update()); },
    setHeight(value) { cc.height = value; },
    async take(event) {
      for (const file of event.target.files)
        await cc.draw({ action: "import", name: file.name.replace(/\.csv$/i, "").replace(/[^\w .+-]/g, "_") || "file", text: await file.text() });
      event.target.value = "";
    },
  },
};

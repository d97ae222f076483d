// What a pilot looks at before take-off; FLY and MISSION ask back where a line is not good.
export default {
  template: `
    <div v-if="checks.length" class="cc-panel cc-preflight" data-testid="preflight">
      <b>{{ isGood ? "GO: ready to fly" : "NO-GO: not ready" }}</b>
      <div v-for="check in checks" :key="check.name" :class="check.ok ? 'cc-good' : 'cc-bad'">
        <q-icon :name="check.ok ? 'check' : 'close'" /> <span>{{ check.name }}</span> {{ check.text }}
      </div>
      <q-dialog v-model="isAsking">
        <div class="cc-panel cc-ask" role="alertdialog" data-testid="preflight-ask">
          <b>NO-GO: not ready to fly</b>
          <div v-for="check in bad" :key="check.name" class="cc-bad">{{ check.name }}: {{ check.text }}</div>
          <div class="cc-row"><q-btn color="primary" label="STAY" autofocus @click="isAsking = false" /><q-btn outline color="negative" label="FLY ANYWAY" @click="go" /></div>
        </div>
      </q-dialog>
    </div>`,
  data: () => ({ checks: [], isAsking: false }),
  computed: {
    bad() { return this.checks.filter((check) => !check.ok); },
    isGood() { return !this.bad.length; },
  },
  mounted() {
    this.offs = [
      cc.on("words", (words) => { if (words.preflight !== undefined) this.checks = words.preflight || []; }),
      cc.on("about to fly", (command) => { if (this.bad.length) { this.command = command; this.isAsking = true; } else cc.command(command); }),
    ];
  },
  unmounted() { this.offs.forEach((off) => off()); },
  methods: {
    go() { this.isAsking = false; cc.command(this.command); },
  },
};

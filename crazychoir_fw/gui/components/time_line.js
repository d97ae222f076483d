// The past of a simulated flight: go back, change something, and fly on; every future that was flown stays.
export default {
  template: `
    <div class="cc-panel">
      <div v-if="problem" class="cc-note">{{ problem }}</div>
      <template v-else>
        <div class="cc-row">
          <q-btn outline :icon="isPaused ? 'play_arrow' : 'pause'" :label="isPaused ? 'FLY ON' : 'PAUSE'" @click="pause" />
          <q-btn-toggle no-caps dense :model-value="speed" :options="speeds" @update:model-value="setSpeed" />
        </div>
        <div v-for="branch in branches" :key="branch.number" class="cc-branch" :class="{ 'cc-chosen': branch.number === present }" data-testid="branch">
          <div class="cc-branch-head"><b>Branch {{ branch.number }}</b>
            <span>{{ branch.begin.toFixed(1) }} to {{ branch.end.toFixed(1) }} s{{ branch.parent === null ? "" : ", from branch " + branch.parent }}</span>
            <q-toggle v-if="branch.number !== present" dense label="show beside" :model-value="!!ghosts[branch.number]" @update:model-value="(on) => ghost(branch.number, on)" />
            <span v-else class="cc-phase">this one flies</span>
          </div>
          <div class="cc-track">
            <q-slider :aria-label="'Time of branch ' + branch.number" :min="0" :max="Math.max(end, 1)" :step="0.1" :model-value="wanted[branch.number] === undefined ? branch.end : wanted[branch.number]"
              label :label-value="(wanted[branch.number] === undefined ? branch.end : wanted[branch.number]).toFixed(1) + ' s'" @update:model-value="(time) => scrub(branch, time)" />
            <div v-for="(mark, k) in branch.marks" :key="k" class="cc-tick" :style="{ left: (100 * mark.time) / Math.max(end, 1) + '%' }" :title="mark.time + ' s: ' + mark.text"></div>
          </div>
          <q-btn dense color="primary" icon="history" :label="'BACK TO ' + (wanted[branch.number] === undefined ? branch.end : wanted[branch.number]).toFixed(1) + ' s'" @click="rewind(branch)" />
        </div>
        <div class="cc-hint">Pull a slider to a time and press BACK: the flight goes on from there as a new branch, with the bits that it had. Pause first, to change parameters or commands before it goes on.</div>
      </template>
    </div>`,
  data: () => ({
    problem: "", branches: [], present: 0, speed: 1, wanted: {}, ghosts: {}, end: 1,
    speeds: [0.25, 0.5, 1, 2, 4, 10].map((value) => ({ label: value + " x", value })),
  }),
  computed: { isPaused() { return this.speed === 0; } },
  mounted() { this.off = cc.on("words", (words) => this.update(words)); this.update(cc.words); },
  unmounted() { this.off(); },
  methods: {
    update(words) {
      if (!words.branches) return;
      Object.assign(this, { branches: words.branches, present: words.branch, speed: words.speed, problem: words.no_rewind || "" });
      this.end = Math.max(...words.branches.map((branch) => branch.end));
    },
    scrub(branch, time) { this.wanted = { ...this.wanted, [branch.number]: time }; },
    pause() { this.setSpeed(this.isPaused ? this.before || 1 : 0); },
    setSpeed(factor) { if (this.speed) this.before = this.speed; this.speed = factor; cc.command({ name: "speed", factor }); },
    async rewind(branch) {
      const wanted = this.wanted[branch.number], time = wanted === undefined ? branch.end : wanted;
      const answer = await cc.command({ name: "rewind", branch: branch.number, time });
      if (answer.ok) { this.wanted = {}; this.ghost(this.present, true); }
    },
    async ghost(number, isShown) {
      if (isShown) {
        try {
          const path = await cc.get(`/api/path?branch=${number}`);
          cc.ghosts[number] = { ...path, positions: path.positions.map(cc.places) };
        } catch (error) { cc.toast(error.message, false); }
      }
      else delete cc.ghosts[number];
      this.ghosts = { ...cc.ghosts };
      cc.emit("branch");
    },
  },
};

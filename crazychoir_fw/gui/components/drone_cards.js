// How each drone is: one card each; a press on its head chooses it.
export default {
  components: { attitudeDial: cc.attitudeDial },
  template: `
    <div class="cc-cards" data-testid="cards">
      <div v-for="card in cards" :key="card.name" class="cc-card" :class="{ 'cc-chosen': card.chosen, 'cc-failed': card.failure }">
        <button class="cc-card-head" @click="choose(card.name)" :aria-pressed="card.chosen">
          <span class="cc-dot" :style="{ background: card.color }"></span>{{ card.name }}
          <span class="cc-phase">{{ card.phase }}</span>
        </button>
        <attitude-dial v-if="card.quat" :quat="card.quat" :motors="card.motors" />
        <div class="cc-card-body">
          <span>battery</span><b :class="{ 'cc-warn': card.battery !== null && card.battery < 3.3 }">{{ card.battery === null ? "-" : card.battery.toFixed(2) + " V" }}</b>
          <span>supervisor</span><b>{{ card.supervisor }}</b>
          <span>place</span><b>{{ card.place ? card.place.map((value) => value.toFixed(2)).join(", ") + " m" : "unknown" }}</b>
          <span>speed</span><b>{{ card.speed ? card.speed[0].toFixed(1) + " m/s" : "-" }}</b>
          <span>estimator</span><b :class="{ 'cc-warn': card.estimate_error > 0.1 }">{{ card.estimate_error === null ? "-" : "off by " + (100 * card.estimate_error).toFixed(1) + " cm" }}</b>
          <span>link</span><b>{{ card.link || "-" }}</b>
          <span>guidance</span><b>{{ card.guidance }}</b>
        </div>
        <div v-if="card.failure" class="cc-card-failure">{{ card.failure }}</div>
        <div class="cc-card-buttons">
          <q-btn dense flat icon="flight_takeoff" :aria-label="'Take off ' + card.name" @click="press('takeoff', card.name)" />
          <q-btn dense flat icon="flight_land" :aria-label="'Land ' + card.name" @click="press('land', card.name)" />
          <q-btn dense flat color="negative" icon="dangerous" :aria-label="'Stop ' + card.name" @click="press('stop', card.name)" />
        </div>
      </div>
    </div>`,
  data: () => ({ cards: [] }),
  mounted() {
    this.told = 0; // without a graphics card a third of it is enough
    this.offs = [
      cc.on("words", () => { if (!cc.isSlow() || ++this.told % 3 === 1) this.update(); }),
      cc.on("selection", () => this.update()),
      // what was there when the tab was left is old, and must not be read for an instant
      cc.on("shown", (tab) => { if (tab === "Fly") requestAnimationFrame(() => this.update()); }),
    ];
    this.update();
  },
  unmounted() { this.offs.forEach((off) => off()); },
  methods: {
    update() {
      if (!cc.setting || !cc.words.cards || !this.$el.offsetParent) return;
      this.cards = cc.words.cards.map((card, i) => ({
        ...card, quat: this.attitude(i), name: cc.setting.names[i], color: cc.color(i), chosen: cc.selection.has(cc.setting.names[i]),
      }));
    },
    attitude(i) {
      const quat = cc.frame?.drones[i]?.quat;
      return quat?.every(Number.isFinite) ? quat : null;
    },
    press: (name, drone) => cc.press(name, [drone]),
    choose: (name) => cc.select(name, false),
  },
};

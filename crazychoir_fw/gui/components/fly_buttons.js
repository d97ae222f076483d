// Buttons for those who are selected, or all: one press each, and nothing asks back.
export default {
  template: `
    <div class="cc-buttons">
      <div class="cc-whom" aria-live="polite">{{ whom }}
        <q-btn v-if="count" dense flat no-caps label="choose all" @click="all" />
      </div>
      <q-btn color="primary" icon="flight_takeoff" label="TAKE-OFF" @click="press('takeoff')"><q-tooltip>Key T</q-tooltip></q-btn>
      <q-btn color="primary" icon="flight_land" label="LAND" @click="press('land')"><q-tooltip>Key L</q-tooltip></q-btn>
      <q-btn v-if="!missing.start" color="positive" icon="play_arrow" label="START" @click="press('start')"><q-tooltip>Begin what the guidance is for</q-tooltip></q-btn>
      <q-btn outline icon="my_location" label="GO TO STARTS" @click="send({ name: 'starts' })"><q-tooltip>Flying drones go to above the starts of the mission, at different heights where their ways meet</q-tooltip></q-btn>
      <q-btn v-if="!missing.mission" color="positive" icon="playlist_play" label="MISSION" @click="fly"><q-tooltip>Fly the phases of the mission: {{ phases }}</q-tooltip></q-btn>
      <q-btn color="negative" icon="dangerous" label="STOP THESE" @click="press('stop')"><q-tooltip>Motors off at once: they fall</q-tooltip></q-btn>
      <div v-if="flying" class="cc-hint" data-testid="in-the-air">'{{ flying.name }}': {{ flying.phase }}
        <q-linear-progress v-if="flying.share !== null" :value="flying.share" aria-label="Part of the mission that is flown" />
      </div>
      <div v-if="missing.arm" class="cc-hint" data-testid="no-arm">{{ missing.arm }}</div>
      <template v-else-if="hasSoftware">
      <q-btn outline label="ARM" @click="send({ name: 'arm', armed: true })" />
      <q-btn outline label="DISARM" @click="send({ name: 'arm', armed: false })" />
      <q-btn outline label="REBOOT" @click="send({ name: 'reboot' })"><q-tooltip>Onboard software starts again; in simulation a fallen drone is set upright, a real one is switched off and on</q-tooltip></q-btn>
      </template>
      <label class="cc-slider">Height of GO TO: {{ height.toFixed(2) }} m
        <q-slider v-model="height" :min="0.1" :max="3" :step="0.05" aria-label="Height of GO TO in metres" @update:model-value="setHeight" />
      </label>
      <div class="cc-hint">Click on the map: the drones go there. Click on a drone: only this one is meant; Shift adds another.</div>
    </div>`,
  data: () => ({ whom: "All drones", count: 0, height: 1.0, missing: {}, phases: "", flying: null, hasSoftware: true }),
  mounted() {
    const choose = () => {
      this.count = cc.selection.size;
      this.whom = this.count ? [...cc.selection].join(", ") : "All drones";
    };
    this.offs = [cc.on("selection", choose), cc.on("setting", () => this.begin()), cc.on("words", ({ flying }) => this.tell(flying))];
    choose();
    this.begin();
  },
  unmounted() { this.offs.forEach((off) => off()); },
  methods: {
    begin() {
      if (!cc.setting) return;
      this.height = cc.height;
      this.missing = cc.setting.missing;
      this.phases = cc.setting.phases.filter((name, k, all) => name !== all[k - 1]).join(", ");
      this.hasSoftware = cc.setting.has_software;
    },
    tell(flying) {
      const share = flying && flying.started !== null && cc.frame ? Math.min(1, (cc.frame.time - flying.started) / flying.duration) : null;
      this.flying = flying && { ...flying, share };
    },
    fly: () => cc.emit("about to fly", { name: "mission" }),
    press: (name) => cc.press(name),
    send: (command) => cc.command({ ...command, drones: cc.chosen() }),
    all: () => cc.selectAll(),
    setHeight(value) { cc.height = value; },
  },
};

// What happened: commands, events, and what the onboard software prints.
const KINDS = [
  { name: "csv", text: "one row for each drone and time, for tables" },
  { name: "mcap", text: "ROS 2 messages, for Foxglove and rosbag" },
  { name: "npz", text: "for Python and crazychoir plot" },
];
export default {
  template: `
    <div class="cc-panel">
      <div class="cc-row"><q-input dense class="cc-name" v-model="search" label="Search" clearable />
        <q-btn outline no-caps icon="download" label="LOG" aria-label="Download the log of the flight">
          <q-menu auto-close><q-list dense>
            <q-item v-for="kind in kinds" :key="kind.name" clickable :data-testid="'log-' + kind.name" @click="download(kind.name)">
              <q-item-section><b>{{ kind.name.toUpperCase() }}</b><span class="cc-hint">{{ kind.text }}</span></q-item-section>
            </q-item>
          </q-list></q-menu>
        </q-btn>
      </div>
      <div class="cc-scroll" ref="scroll" role="log" data-testid="console">
        <div v-for="line in shown" :key="line.number" class="cc-line" :class="'cc-' + line.kind">
          <span>{{ line.time.toFixed(2) }} s</span><span>{{ line.drone }}</span><span>{{ line.text }}</span>
        </div>
      </div>
    </div>`,
  data: () => ({ lines: [], search: "", kinds: KINDS }),
  computed: {
    shown() {
      const word = (this.search || "").toLowerCase();
      return this.lines.filter((line) => !word || `${line.drone} ${line.text} ${line.kind}`.toLowerCase().includes(word)).slice(-300);
    },
  },
  mounted() {
    this.update = () => {
      const scroll = this.$refs.scroll, isAtEnd = scroll.scrollTop + scroll.clientHeight > scroll.scrollHeight - 40;
      this.lines = cc.lines.slice();
      if (isAtEnd) this.$nextTick(() => { scroll.scrollTop = scroll.scrollHeight; });
    };
    this.off = cc.on("lines", this.update);
    this.update();
  },
  unmounted() { this.off(); },
  methods: {
    async download(kind) {
      try {
        const response = await fetch(`/api/log.${kind}`);
        if (!response.ok) { cc.toast((await response.json()).text, false); return; }
        const link = document.createElement("a");
        link.href = URL.createObjectURL(await response.blob());
        link.download = (/filename="([^"]+)"/.exec(response.headers.get("content-disposition")) || [])[1] || `flight.${kind}`;
        link.click();
        setTimeout(() => URL.revokeObjectURL(link.href), 60000);
      } catch { cc.toast("The log did not come: is `crazychoir gui` still running?", false); }
    },
  },
};

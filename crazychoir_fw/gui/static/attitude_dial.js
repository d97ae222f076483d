// Artificial horizon of one drone, with a bar for the duty of each motor where it is known.
(() => {
  const RADIUS = 20, PITCH_PER_DEG = 0.5; // [px], of the ball; 40 deg fill it
  cc.attitudeDial = {
    props: ["quat", "motors"], // x, y, z, w; duties, 0 to 1
    template: `
      <svg class="cc-dial" viewBox="0 0 72 44" role="img" :aria-label="words">
        <title>{{ words }}</title>
        <g transform="translate(22 22)">
          <clipPath :id="id"><circle r="${RADIUS}" /></clipPath>
          <g :clip-path="'url(#' + id + ')'">
            <g :transform="'rotate(' + -roll + ') translate(0 ' + sunk + ')'">
              <rect x="-60" y="-120" width="120" height="120" class="cc-sky" /><rect x="-60" y="0" width="120" height="120" class="cc-ground" />
              <path d="M-60 0H60" class="cc-skyline" />
            </g>
          </g>
          <circle r="${RADIUS}" class="cc-rim" /><path d="M-12 0H-4L0 4L4 0H12" class="cc-wings" />
        </g>
        <g v-for="(duty, k) in motors" :key="k">
          <rect :x="48 + 6 * k" y="2" width="4" height="40" class="cc-bar" />
          <rect :x="48 + 6 * k" :y="42 - 40 * duty" width="4" :height="40 * duty" class="cc-duty" :class="{ 'cc-full': duty > 0.95 }" />
        </g>
      </svg>`,
    data: () => ({ id: "cc-ball-" + Math.random().toString(36).slice(2) }),
    computed: {
      // positive: right side down, nose up, as in stateEstimate
      roll() {
        const [x, y, z, w] = this.quat;
        return (180 / Math.PI) * Math.atan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y));
      },
      pitch() {
        const [x, y, z, w] = this.quat;
        return (180 / Math.PI) * Math.asin(Math.max(-1, Math.min(1, 2 * (z * x - w * y))));
      },
      // the nose goes up, the horizon down
      sunk() { return PITCH_PER_DEG * Math.max(-90, Math.min(90, this.pitch)); },
      words() {
        const turned = `roll ${Math.round(this.roll) + 0}, pitch ${Math.round(this.pitch) + 0} deg`; // + 0: no -0
        return this.motors.length ? `${turned}, motors ${this.motors.map((duty) => (100 * duty).toFixed(0)).join(", ")} %` : turned;
      },
    },
  };
})();

// Plots over time and from above, by ECharts, which NiceGUI brings along.
import { echarts } from "nicegui-echart";

const LINKED = "live";
const RED = "rgb(220,40,40)", TOP = 50, LEFT = 54, RIGHT = 14, BOTTOM = 24; // pixels

// series: [{name, color, points: [[x, y]], dash, width}]; limits: [{value, name}]; spans: [[begin, end]]; isMap: both axes
// are in meters and have one scale; canZoom: the wheel zooms in time
export const plot = (box, { series, limits = [], spans = [], title = "", unit = "", isMap = false, canZoom = false }) => {
  const chart = echarts.getInstanceByDom(box) || echarts.init(box);
  // plots of one time axis have one pointer and one zoom
  if (canZoom && chart.group !== LINKED) { chart.group = LINKED; echarts.connect(LINKED); }
  if (chart.getWidth() !== box.clientWidth || chart.getHeight() !== box.clientHeight) chart.resize();
  const [x, y] = ranges(series, limits, isMap && [box.clientWidth - LEFT - RIGHT, box.clientHeight - TOP - BOTTOM]);
  const label = { color: cc.ink(0.65), hideOverlap: true, showMinLabel: false, showMaxLabel: false };
  const axis = { type: "value", axisLine: { show: false }, axisTick: { show: false } };
  const grid = { lineStyle: { color: cc.ink(0.12) } };
  const marks = {
    markLine: { silent: true, symbol: "none", data: limits.map(({ value, name }) => ({ yAxis: value, name })),
      lineStyle: { color: RED, type: "dashed" }, label: { formatter: "{b}", color: RED, position: "insideEndTop" } },
    markArea: { silent: true, itemStyle: { color: "rgba(220,40,40,0.22)" }, data: spans.map(([a, b]) => [{ xAxis: a }, { xAxis: b }]) },
  };
  chart.setOption({
    animation: false,
    title: [
      { text: title + (unit ? ` (${unit})` : ""), left: 8, top: 4, textStyle: { fontSize: 12, fontWeight: "normal", color: cc.ink(0.85) } },
      { text: x.min === undefined ? "no data yet" : "", left: "center", top: "middle", textStyle: { fontSize: 12, fontWeight: "normal", color: cc.ink(0.5) } },
    ],
    ...(canZoom ? { dataZoom: [{ type: "inside", filterMode: "none" }] } : {}),
    legend: { show: !isMap, type: series.length > 4 ? "scroll" : "plain", left: 4, right: 4, top: 22, itemWidth: 12, itemHeight: 3, icon: "rect", textStyle: { color: cc.ink(0.8) },
      pageTextStyle: { color: cc.ink(0.8) }, pageIconSize: 10 },
    tooltip: { show: !isMap, trigger: "axis", confine: true, valueFormatter: (value) => (value == null ? "-" : String(Number(value.toPrecision(5)))) },
    grid: { left: LEFT, right: RIGHT, top: TOP, bottom: BOTTOM },
    xAxis: { ...axis, ...x, splitLine: { show: isMap, ...grid }, axisLabel: { ...label, formatter: (value) => `${Number(value.toPrecision(6))} ${isMap ? "m" : "s"}` } },
    yAxis: { ...axis, ...y, splitLine: grid, axisLabel: label },
    series: series.map(({ name, color, points, dash, width = 1.6 }, k) => ({
      name, color, type: "line", data: points, showSymbol: false, lineStyle: { width, type: dash || "solid" }, ...(k === 0 ? marks : {}),
    })),
  }, { replaceMerge: ["series"] });
};

export const endPlots = (element) => element.querySelectorAll(".cc-plot").forEach((box) => echarts.getInstanceByDom(box)?.dispose());

const ranges = (series, limits, size) => {
  let x0 = Infinity, x1 = -Infinity, y0 = Infinity, y1 = -Infinity;
  const see = (x, y) => { x0 = Math.min(x0, x); x1 = Math.max(x1, x); y0 = Math.min(y0, y); y1 = Math.max(y1, y); };
  for (const { points } of series) for (const [x, y] of points) if (y !== null && !Number.isNaN(y)) see(x, y);
  if (!(x1 > x0)) return [{}, {}];
  limits.forEach(({ value }) => see(x0, value));
  if (size) {
    const half = (0.55 * Math.max(0.5 / size[0], (x1 - x0) / size[0], (y1 - y0) / size[1])); // meters for a pixel, halved
    const [x, y] = [(x0 + x1) / 2, (y0 + y1) / 2];
    return [{ min: x - half * size[0], max: x + half * size[0] }, { min: y - half * size[1], max: y + half * size[1] }];
  }
  const pad = Math.max((y1 - y0) * 0.06, 1e-6 * Math.abs(y1), y1 === y0 ? 0.5 : 0);
  return [{ min: x0, max: x1 }, { min: y0 - pad, max: y1 + pad }];
};

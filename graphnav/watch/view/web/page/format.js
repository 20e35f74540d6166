// Format numbers with stable widths.

export const NONE = "–";

export function rate(hz) {
  if (hz === null || hz === undefined) return NONE;
  return `${hz < 1 ? hz.toFixed(2) : hz < 1000 ? hz.toFixed(1) : hz.toFixed(0)} Hz`;
}

export function milliseconds(ms) {
  if (ms === null || ms === undefined) return NONE;
  if (ms >= 10000) return `${(ms / 1000).toFixed(0)} s`;
  return `${ms < 10 ? ms.toFixed(1) : ms.toFixed(0)} ms`;
}

export function seconds(s) {
  if (s === null || s === undefined) return NONE;
  return s < 99.95 ? `${s.toFixed(1)} s` : `${s.toFixed(0)} s`;
}

export function size(bytes) {
  if (bytes < 1000) return `${bytes} B`;
  return bytes < 1e6 ? `${(bytes / 1000).toFixed(1)} kB` : `${(bytes / 1e6).toFixed(2)} MB`;
}

export function count(n) {
  return n < 100000 ? String(n) : n < 1e6 ? `${(n / 1000).toFixed(0)}k` : `${(n / 1e6).toPrecision(3)}M`;
}

export function number(value) {
  if (value === null || value === undefined) return "not finite";
  if (Number.isSafeInteger(value)) return String(value);
  const size = Math.abs(value);
  return size >= 1e5 || size < 1e-4 ? value.toExponential(3) : value.toFixed(size >= 1000 ? 1 : size >= 10 ? 2 : 4);
}

// A field of a message, summarised by the server.
export function field(value) {
  if (value === null) return "not finite";
  if (typeof value === "number") return number(value);
  if (typeof value === "string") return JSON.stringify(value);
  if (typeof value !== "object") return String(value);
  if (Array.isArray(value.values)) return `[${value.values.map(number).join(", ")}]`;
  if (!Array.isArray(value.shape)) return Object.entries(value).map(([name, item]) => `${name}: ${field(item)}`).join(", ");
  const parts = [`${value.dtype} (${value.shape.join(", ")})`];
  if (value.valid_ratio !== undefined) parts.push(`${(100 * value.valid_ratio).toFixed(1)} % valid`);
  else if (value.min !== undefined) parts.push(`${number(value.min)} to ${number(value.max)}, mean ${number(value.mean)}`);
  if (value.finite_ratio !== undefined) parts.push(`${(100 * value.finite_ratio).toFixed(1)} % finite`);
  return parts.join("  ");
}

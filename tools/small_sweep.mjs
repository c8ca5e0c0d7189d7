// For the scripts that disturb sweeps: a small plan, and what is left of one that no clock decides.
export const small_plan = `name = "small"
[scenario]
width = 64
height = 48
[[scenario.character]]
source = "mannequin:triangles=500"
[axes]
crowd.agents = [1, 2, 3]
representation = ["mesh", "mesh:triangles=250"]
[points]
repetitions = 2
[measure]
rounds = 10
time_limit_s = 0.05
scores = ["mae"]
`

// What the file holds of each point, times left out: one text. rows: what `sweep --json` prints.
export function held_of_sweep(rows) {
  const scores = new Map(rows.comparisons.map((c) => [c.id, c.scores]))
  const points = rows.sweep_points.map((p) => [p.condition, p.repetition, p.role, p.point_key, p.representation, p.settings, p.state,
    JSON.stringify(scores.get(p.comparison) ?? null)].join(' '))
  const sorted = [...points].sort()
  if (new Set(sorted).size !== sorted.length) return 'a point is there twice'
  if (rows.measurements.length !== rows.sweep_points.filter((p) => p.measurement !== null).length) return 'a measurement is of no point'
  return sorted.join('\n')
}

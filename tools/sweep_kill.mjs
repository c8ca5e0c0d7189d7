// Kills a sweep with SIGKILL at random moments, starts it again each time, and looks whether a point was lost or measured twice:
// what is left in the end must be what an undisturbed sweep leaves, but for the times.
//
//   node tools/sweep_kill.mjs DRIVER FOLDER [KILLS]    200 kills where it is not said
//
// Status 0: every sweep held; 1: one did not, and how is said.
import { execFileSync, spawn } from 'node:child_process'
import { existsSync, mkdirSync, rmSync, writeFileSync } from 'node:fs'
import { join } from 'node:path'

const [driver, folder, kills = '200'] = process.argv.slice(2)
if (!driver || !folder || !(Number(kills) >= 1)) {
  console.error('usage: sweep_kill.mjs DRIVER FOLDER [KILLS]')
  process.exit(2)
}
mkdirSync(folder, { recursive: true })
const plan = join(folder, 'kill.toml')
writeFileSync(plan, `name = "kill"
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
`)

const store = (name) => join(folder, `${name}.sqlite`)
const forget = (name) => {
  for (const end of ['', '.partial', '.partial-wal', '.partial-shm', '.partial.new', '.lock']) rmSync(store(name) + end, { force: true })
}
const args = (name) => ['sweep', plan, '--out', store(name), '--json']
// What the file holds of each point, times left out: one text.
const held = (name) => {
  const rows = JSON.parse(execFileSync(driver, args(name), { maxBuffer: 1 << 28, stdio: ['ignore', 'pipe', 'ignore'] }))
  const scores = new Map(rows.comparisons.map((c) => [c.id, c.scores]))
  const points = rows.sweep_points.map((p) => [p.condition, p.repetition, p.role, p.point_key, p.representation, p.settings, p.state,
    JSON.stringify(scores.get(p.comparison) ?? null)].join(' '))
  const sorted = [...points].sort()
  if (new Set(sorted).size !== sorted.length) return 'a point is there twice'
  if (rows.measurements.length !== rows.sweep_points.filter((p) => p.measurement !== null).length) return 'a measurement is of no point'
  return sorted.join('\n')
}
const sleep = (ms) => new Promise((wake) => setTimeout(wake, ms))

// Killed after so many milliseconds, or ended before.
async function run_for(ms) {
  const child = spawn(driver, args('killed'), { stdio: 'ignore' })
  const ended = new Promise((done) => child.on('exit', done))
  const finished = await Promise.race([ended.then(() => true), sleep(ms).then(() => false)])
  if (!finished) child.kill('SIGKILL')
  await ended
  return !finished
}

forget('whole')
const begun = Date.now()
const wanted = held('whole')
const whole_ms = Date.now() - begun
let killed = 0
let sweeps = 0
let faults = 0
function judge() {
  ++sweeps
  const left = held('killed')
  if (left !== wanted) {
    ++faults
    console.log(`after ${killed} kills: ${left.includes('\n') ? 'other points than undisturbed' : left}`)
  }
  forget('killed')
}
forget('killed')
while (killed < Number(kills)) {
  if (await run_for(Math.random() * whole_ms)) ++killed
  if (existsSync(store('killed'))) judge()
}
judge()
console.log(`${killed} kills, ${sweeps} sweeps ended, ${faults} of them with another result than undisturbed`)
process.exit(faults === 0 ? 0 : 1)

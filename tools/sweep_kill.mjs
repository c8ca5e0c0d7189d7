// Kills a sweep with SIGKILL at random moments, starts it again each time, and looks whether a point was lost or measured twice:
// what is left in the end must be what an undisturbed sweep leaves, but for the times.
//
//   node tools/sweep_kill.mjs DRIVER FOLDER [KILLS]    200 kills where it is not said
//
// Status 0: every sweep held; 1: one did not, and how is said.
import { execFileSync, spawn } from 'node:child_process'
import { existsSync, mkdirSync, rmSync, writeFileSync } from 'node:fs'
import { join } from 'node:path'
import { held_of_sweep, small_plan } from './small_sweep.mjs'

const [driver, folder, kills = '200'] = process.argv.slice(2)
if (!driver || !folder || !(Number(kills) >= 1)) {
  console.error('usage: sweep_kill.mjs DRIVER FOLDER [KILLS]')
  process.exit(2)
}
mkdirSync(folder, { recursive: true })
const plan = join(folder, 'kill.toml')
writeFileSync(plan, small_plan)

const store = (name) => join(folder, `${name}.sqlite`)
const forget = (name) => {
  for (const end of ['', '.partial', '.partial-wal', '.partial-shm', '.partial.new', '.lock']) rmSync(store(name) + end, { force: true })
}
const args = (name) => ['sweep', plan, '--out', store(name), '--json']
const held = (name) =>
  held_of_sweep(JSON.parse(execFileSync(driver, args(name), { maxBuffer: 1 << 28, stdio: ['ignore', 'pipe', 'ignore'] })))
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

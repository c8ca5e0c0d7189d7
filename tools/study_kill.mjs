// Kills the server of a study with SIGKILL at random moments while many clients answer, starts it again each time, and looks
// whether anything that was acknowledged is lost, or kept twice. The clients are simulated: they answer as fast as they can.
//
//   node tools/study_kill.mjs DRIVER FOLDER [--kills 1000] [--clients 50]
//
// It says what the server bore: posts acknowledged a second, and how long one took. Ctrl-C ends it early, with the kills so far.
// Status 0: nothing was lost; 1: something was, and what is said.
import { createHash } from 'node:crypto'
import { execFileSync, spawn } from 'node:child_process'
import { mkdirSync, rmSync, writeFileSync } from 'node:fs'
import { request } from 'node:http'
import { join } from 'node:path'
import { parseArgs } from 'node:util'

const { values: options, positionals } = parseArgs({
  allowPositionals: true,
  options: { kills: { type: 'string', default: '1000' }, clients: { type: 'string', default: '50' } }
})
const [driver, folder] = positionals
const kills = Number(options.kills)
const clients = Number(options.clients)
if (positionals.length !== 2 || !(kills >= 1) || !(clients >= 1)) {
  console.error('usage: study_kill.mjs DRIVER FOLDER [--kills N] [--clients N]')
  process.exit(2)
}

// ---- a study without clips

const study = 'c'.repeat(64)
const kTrials = 20
const trials = Array.from({ length: kTrials }, (_, i) => ({ trial: `t${i}`, stimulus: 's1', block: 1, kind: 'main' }))
const out = join(folder, 'study')
rmSync(out, { recursive: true, force: true })
mkdirSync(join(out, 'page'), { recursive: true })
writeFileSync(join(out, 'page', 'index.html'), '')
writeFileSync(join(out, 'sides.json'), JSON.stringify({ stimuli: { s1: { kind: 'test', expected: 'upper' } } }))
writeFileSync(join(out, 'page', 'trials.json'), JSON.stringify({
  format: 1, study, task: 'forced-choice', answers: [{ value: 'upper' }, { value: 'lower' }], stimuli: { s1: {} },
  lists: ['1', '2', '3'].map((id) => ({ id, trials }))
}))

// ---- the server

let server
let port = 0
const sleep = (ms) => new Promise((wake) => setTimeout(wake, ms))
function start() {
  server = spawn(driver, ['study', 'serve', out, '--port', String(port)], { stdio: ['ignore', 'pipe', 'pipe'] })
  return new Promise((resolve, reject) => {
    server.stdout.on('data', (text) => {
      port = Number(/:(\d+)\//.exec(text)[1])
      resolve()
    })
    server.on('exit', (status) => { if (status !== null) reject(new Error(`the server ended with ${status}`)) })
  })
}
async function kill() {
  const ended = new Promise((done) => server.on('exit', done))
  server.kill('SIGKILL')
  await ended
}

// ---- the clients

const acknowledged = new Map()  // "participant item" -> answer
const times = []
let over = false
function post(path, body, token) {
  return new Promise((resolve) => {
    const text = JSON.stringify(body)
    const headers = { 'Content-Type': 'application/json', 'Content-Length': Buffer.byteLength(text) }
    if (token) headers['X-Study-Token'] = token
    const sent = request({ host: '127.0.0.1', port, path, method: 'POST', headers, agent: false }, (answer) => {
      let said = ''
      answer.on('data', (part) => { said += part })
      answer.on('end', () => resolve({ status: answer.complete ? answer.statusCode : 0, said }))
      answer.on('error', () => resolve({ status: 0, said: '' }))
    })
    sent.on('error', () => resolve({ status: 0, said: '' }))
    sent.end(text)
  })
}
// As the page does: what was not acknowledged is sent again.
async function insist(path, body, token) {
  for (;;) {
    const begun = performance.now()
    const { status, said } = await post(path, body, token)
    if (status === 200) {
      times.push(performance.now() - begun)
      return JSON.parse(said)
    }
    if (over) return null
    if (status !== 0 && status !== 500) throw new Error(`${path} was answered ${status}: ${said}`)
    await sleep(5)
  }
}
async function client(number) {
  for (let round = 0; !over; ++round) {
    const participant = createHash('sha256').update(`simulated ${number} ${round}`).digest('hex')
    const begun = await insist('/api/start', { study, participant })
    if (!begun) return
    for (const { trial } of trials) {
      const answer = Math.random() < 0.5 ? 'upper' : 'lower'
      const row = { item: trial, kind: 'main', stimulus: 's1', answer, rt_ms: Math.round(Math.random() * 3000), replays: 0, hidden: 0, restarts: 0 }
      if (!(await insist('/api/answer', row, begun.token))) return
      acknowledged.set(`${participant} ${trial}`, answer)
    }
  }
}

// ---- the run

await start()
const running = Array.from({ length: clients }, (_, number) => client(number))
let up = 0
let killed = 0
let enough = false
process.once('SIGINT', () => { enough = true })
while (killed < kills && !enough) {
  // After some answers and a moment: also a machine that does much else gets to answer.
  const begun = performance.now()
  const until = times.length + 20 * Math.random()
  while (times.length < until) await sleep(1)
  await sleep(10 * Math.random())
  up += performance.now() - begun
  await kill()
  await start()
  if (++killed % 100 === 0) console.error(`${killed} kills, ${acknowledged.size} answers acknowledged`)
}
over = true
await Promise.all(running)
await kill()

const lines = join(folder, 'answers.jsonl')
execFileSync(driver, ['study', 'answers', join(out, 'answers.sqlite'), '--study', out, '--json-lines', lines])
const { createReadStream } = await import('node:fs')
const { createInterface } = await import('node:readline')
const kept = new Map()
let twice = 0
for await (const line of createInterface({ input: createReadStream(lines) })) {
  const row = JSON.parse(line)
  const key = `${row.participant} ${row.item}`
  if (kept.has(key)) ++twice
  kept.set(key, row.answer)
}
let lost = 0
let changed = 0
for (const [key, answer] of acknowledged) {
  if (!kept.has(key)) ++lost
  else if (kept.get(key) !== answer) ++changed
}
times.sort((a, b) => a - b)
const at = (share) => times[Math.min(times.length - 1, Math.floor(share * times.length))].toFixed(1)
console.log(`${killed} kills under ${clients} simulated clients: ${acknowledged.size} answers acknowledged, ${lost} lost, ${changed} changed, ${twice} kept twice`)
console.log(`${(times.length / up * 1000).toFixed(0)} posts acknowledged a second of running; one took ${at(0.5)} ms (median), ${at(0.95)} ms (95 %), ${at(0.99)} ms (99 %)`)
process.exit(lost + changed + twice === 0 ? 0 : 1)

// A simulated observer: takes a study from consent to debrief in a real browser, headless, as a participant would, and says
// what it chose. What it answers is simulated, and every line that it prints says so.
//
//   node tools/study_observer.mjs URL [--browser chromium|firefox] [--participant NAME] [--seed N] [--keyboard]
//     [--study OUT --threshold T --slope S]   right with the probability of a logistic function of the stimulus's level
//     [--reload N] [--hide N] [--crash N]     in the middle of trial N: reload; another tab in front; kill the browser, come back
//     [--another N]                           in the middle of trial N: the browser ends and a new one, which knows nothing, goes on
//     [--wait N --until FILE]                 in the middle of trial N: nothing, until that file is there; then reload
//     [--lost N]                              no network while trial N is answered
//     [--full-screen] [--no-calibration] [--withdraw N] [--width W --height H] [--pictures FOLDER] [--profile FOLDER]
//
// Status 0: it came to the end; 1: it did not, and why is said; 2: wrong options; 77: there is no such browser.
import { createHash } from 'node:crypto'
import { existsSync, mkdirSync, mkdtempSync, readFileSync, rmSync } from 'node:fs'
import { tmpdir } from 'node:os'
import { join } from 'node:path'
import { parseArgs } from 'node:util'
import puppeteer from 'puppeteer-core'

const text = { type: 'string' }
const flag = { type: 'boolean', default: false }
let options
let urls
try {
  ({ values: options, positionals: urls } = parseArgs({
    allowPositionals: true,
    options: {
      browser: { ...text, default: 'chromium' }, participant: text, seed: { ...text, default: '1' }, keyboard: flag, study: text,
      threshold: text, slope: text, reload: text, hide: text, crash: text, another: text, wait: text, until: text, lost: text, 'full-screen': flag,
      'no-calibration': flag, withdraw: text, width: { ...text, default: '1280' }, height: { ...text, default: '900' },
      pictures: text, profile: text
    }
  }))
} catch (error) {
  console.error(`study_observer: ${error.message}`)
  process.exit(2)
}
const programs = { chromium: '/usr/bin/chromium', firefox: '/usr/bin/firefox-esr' }
if (urls.length !== 1 || !programs[options.browser]) {
  console.error('usage: study_observer.mjs URL [--browser chromium|firefox] [options]')
  process.exit(2)
}
if (!existsSync(programs[options.browser])) {
  console.error(`${programs[options.browser]} is not installed (${options.browser === 'firefox' ? 'firefox-esr' : 'chromium'})`)
  process.exit(77)
}

const firefox = options.browser === 'firefox'
let profile = options.profile ?? mkdtempSync(join(tmpdir(), 'crowdbench-observer-'))
const at = Object.fromEntries(['reload', 'hide', 'crash', 'another', 'wait', 'lost', 'withdraw'].map((name) => [name, Number(options[name] ?? 0)]))
const url = new URL(urls[0])
if (options.participant) url.searchParams.set('PROLIFIC_PID', options.participant)
const sleep = (ms) => new Promise((wake) => setTimeout(wake, ms))

// A number in [0, 1) that follows from the seed and from what it is for.
const chance = (purpose) => parseInt(createHash('sha256').update(`${options.seed}/${purpose}`).digest('hex').slice(0, 12), 16) / 2 ** 48
const sides = options.study ? JSON.parse(readFileSync(join(options.study, 'sides.json'), 'utf8')).stimuli : null

function choose(trial, answers) {
  const side = sides?.[trial.stimulus]
  const other = (value) => answers.filter((each) => each !== value && each !== 'cannot-tell')[0]
  if (side?.expected && typeof side.level === 'number' && options.threshold !== undefined) {
    const seen = 1 / (1 + Math.exp(-Number(options.slope ?? 1) * (side.level - Number(options.threshold))))
    return chance(trial.item) < 0.5 + 0.5 * seen ? side.expected : other(side.expected)
  }
  return answers[Math.floor(chance(trial.item) * answers.length)]
}

async function launch() {
  const size = { width: Number(options.width), height: Number(options.height) }
  return puppeteer.launch({
    browser: firefox ? 'firefox' : 'chrome', executablePath: programs[options.browser], headless: true, userDataDir: profile,
    defaultViewport: size,
    args: firefox ? [] : ['--no-sandbox', '--disable-gpu', '--disable-quic', '--no-first-run', '--disable-background-networking',
      '--disable-component-update', '--disable-sync']
  })
}

let browser
let page
const said = { observers: 'simulated', browser: options.browser, chosen: [], screens: [], requests_elsewhere: [], errors: [], state: null }
async function open(address) {
  page = await browser.newPage()
  page.on('request', (request) => {
    const to = new URL(request.url())
    if (to.origin !== url.origin && to.protocol.startsWith('http')) said.requests_elsewhere.push(request.url())
  })
  page.on('pageerror', (error) => said.errors.push(String(error.message)))
  await page.goto(address, { waitUntil: 'load' })
}

const pictured = new Set()
async function picture(name) {
  if (!said.screens.includes(name)) said.screens.push(name)
  if (!options.pictures || pictured.has(name)) return
  pictured.add(name)
  mkdirSync(options.pictures, { recursive: true })
  await page.screenshot({ path: join(options.pictures, `${name}.png`) })
}

// Presses a button by a click, or by Tab and Enter alone.
async function press(selector) {
  if (!options.keyboard) return page.click(selector)
  for (let tabs = 0; tabs < 40; ++tabs) {
    if (await page.evaluate((s) => document.activeElement?.matches(s) === true, selector)) return page.keyboard.press('Enter')
    await page.keyboard.press('Tab')
  }
  throw new Error(`the keyboard does not reach ${selector}`)
}

// What is on the screen, in a word.
const look = () => page.evaluate(() => {
  const has = (selector) => document.querySelector(selector) !== null
  if (document.body.dataset.state) return `end:${document.body.dataset.state}`
  if (has('.trial.open')) return 'answer'
  if (has('.trial')) return 'clip'
  if (has('#card')) return 'card'
  if (has('#press')) return 'spot'
  if (has('#plate')) return 'plate'
  if (has('#again:not([hidden])')) return 'again'
  if (has('#jspsych-survey-html-form')) return has('#comments') ? 'comments' : 'form'
  if (has('#jspsych-html-button-response-btngroup button:not([disabled])')) {
    const title = document.querySelector('#stage h1, #stage h2')?.textContent ?? ''
    if (/full screen/i.test(title)) return 'full-screen'
    if (/break/i.test(title)) return 'break'
    return document.getElementById('bar').hidden ? 'consent' : 'text'
  }
  return 'wait'
})

const current = () => page.evaluate(() => {
  const { item, stimulus, kind } = Study.jsPsych.getCurrentTrial().data
  return { item, stimulus, kind, keys: Array.from(document.querySelectorAll('.answers button'), (b) => [b.value, b.querySelector('kbd')?.textContent.toLowerCase()]) }
})

let trials = 0
let disturbed = null
async function disturb(trial) {
  if (disturbed === trial.item) return
  const number = said.chosen.length + 1
  disturbed = trial.item
  if (number === at.reload) await page.reload({ waitUntil: 'load' })
  if (number === at.hide) {
    const other = await browser.newPage()
    await other.bringToFront()
    await sleep(700)
    await page.bringToFront()
    await other.close()
  }
  if (number === at.wait) {
    for (let waits = 0; !existsSync(options.until) && waits < 600; ++waits) await sleep(100)
    await page.reload({ waitUntil: 'load' })
  }
  if (number === at.another) {
    await browser.close()
    if (!options.profile) rmSync(profile, { recursive: true, force: true, maxRetries: 5 })
    profile = mkdtempSync(join(tmpdir(), 'crowdbench-observer-'))
    browser = await launch()
    await open(url.href)
  }
  if (number === at.crash) {
    browser.process().kill('SIGKILL')
    await sleep(500)
    browser = await launch()
    await open(url.href)
  }
}
async function answer() {
  const trial = await current()
  const value = choose(trial, trial.keys.map(([each]) => each))
  await picture('answer')
  const by = options.keyboard || trials++ % 2 === 0 ? 'key' : 'button'
  const lost = said.chosen.length + 1 === at.lost
  if (lost) await page.setOfflineMode(true)
  if (by === 'key') await page.keyboard.press(trial.keys.find(([each]) => each === value)[1])
  else await page.click(`.answers button[value="${value}"]`)
  if (lost) {
    await sleep(900)
    await picture('lost')
    await page.setOfflineMode(false)
  }
  said.chosen.push({ trial: trial.item, stimulus: trial.stimulus, kind: trial.kind, answer: value, by })
}
async function spot() {
  if (options['no-calibration']) return press('#skip')
  await press('#press')
  await sleep(900 + 200 * chance(`spot ${said.screens.length}`))
  return options.keyboard ? page.keyboard.press(' ') : page.click('#press')
}
async function card() {
  if (options['no-calibration']) return press('#skip')
  if (options.keyboard) for (let i = 0; i < 5; ++i) await page.keyboard.press('ArrowRight')
  else await page.$eval('#width', (slider) => { slider.value = 320; slider.dispatchEvent(new Event('input')) })
  return press('#fits')
}
async function form() {
  const fields = await page.$$('#jspsych-survey-html-form input:not([type=submit]), #jspsych-survey-html-form textarea')
  if (fields.length > 0) await fields[0].type('simulated')
  return press('#jspsych-survey-html-form-next')
}
const first = '#jspsych-html-button-response-btngroup button'
const acts = {
  consent: () => press(first), text: () => press(first), break: () => press(first), card, spot, form, comments: form, answer,
  plate: () => press('.digits button[value="5"]'), again: () => press('#again'),
  'full-screen': () => press(options['full-screen'] ? first : `${first} + button`),
  clip: async () => {
    await picture('clip')
    await disturb(await current().catch(() => ({})))
  },
  wait: () => {}
}

async function run() {
  browser = await launch()
  await open(url.href)
  for (let idle = 0; idle < 600;) {
    const shows = await look().catch(() => 'wait')
    if (shows.startsWith('end:')) {
      said.state = shows.slice(4)
      await picture(said.state)
      // Where no server of ours is, what the page would save.
      said.saved = await page.evaluate(() => (document.getElementById('save-json') ? Study.session.rows() : []))
      return
    }
    if (at.withdraw > 0 && said.chosen.length >= at.withdraw && shows === 'clip') {
      await press('#leave')
      await picture('leaving')
      await press('#leaving button[value="withdraw"]')
      at.withdraw = 0
    } else {
      if (!['clip', 'wait'].includes(shows)) await picture(shows)
      await acts[shows]()
    }
    idle = shows === 'wait' || shows === 'clip' ? idle + 1 : 0
    await sleep(50)
  }
  throw new Error('nothing happens any more')
}

let status = 0
try {
  await run()
  said.address = await page.evaluate(() => window.location.href)
} catch (error) {
  said.errors.push(error.message)
  if (page) await picture('failed').catch(() => {})
  status = 1
}
console.log(JSON.stringify(said, null, 1))
await browser?.close().catch(() => {})
if (!options.profile) rmSync(profile, { recursive: true, force: true, maxRetries: 5 })
process.exit(status)

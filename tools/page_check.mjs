// Opens a page that crowdbench wrote in a real browser, headless, wide and narrow, light and dark, and says what is wrong
// with it: messages in the console, charts that were not drawn, requests to elsewhere, sideways scroll, text that a chart
// cuts off, tick labels or names in a legend that overlap, or a name and an axis's title. Prints JSON, with how long the page
// took to open and the text of every table that has an id.
//
//   node tools/page_check.mjs PAGE.html [--pictures FOLDER] [--wait SECONDS]   that long at most for the charts
//   node tools/page_check.mjs PAGE.html --opens N   checks nothing: opens it N times and prints how long each took, seconds:
//     load (the browser's loadEventEnd since the navigation began), seen (until it may be read), cpu (of all processes of
//     the browser meanwhile)
//
// Status 0: nothing is wrong; 1: something is; 2: wrong options; 77: there is no chromium.
import { existsSync, mkdirSync, mkdtempSync, readFileSync, readdirSync, rmSync } from 'node:fs'
import { tmpdir } from 'node:os'
import { join, resolve } from 'node:path'
import { pathToFileURL } from 'node:url'
import { parseArgs } from 'node:util'
import puppeteer from 'puppeteer-core'

let options
let pages
try {
  ({ values: options, positionals: pages } = parseArgs({ allowPositionals: true, options: { pictures: { type: 'string' }, wait: { type: 'string', default: '60' }, opens: { type: 'string', default: '0' } } }))
} catch (error) {
  console.error(`page_check: ${error.message}`)
  process.exit(2)
}
const opens = Number(options.opens)
if (pages.length !== 1 || !existsSync(pages[0]) || !(Number(options.wait) > 0) || !(Number.isInteger(opens) && opens >= 0 && opens <= 1000)) {
  console.error('usage: page_check.mjs PAGE.html [--pictures FOLDER] [--wait SECONDS] | --opens N')
  process.exit(2)
}
const program = '/usr/bin/chromium'
if (!existsSync(program)) {
  console.error(`${program} is not installed (chromium)`)
  process.exit(77)
}
const url = pathToFileURL(resolve(pages[0])).href
const profile = mkdtempSync(join(tmpdir(), 'crowdbench-page-'))
if (options.pictures) mkdirSync(options.pictures, { recursive: true })

// Processor time that a process and all that it began have taken, seconds (a hundredth is the step of /proc).
function cpu_of(root) {
  const children = new Map()
  const ticks = new Map()
  for (const entry of readdirSync('/proc')) {
    if (!/^\d+$/.test(entry)) continue
    let stat
    try { stat = readFileSync(`/proc/${entry}/stat`, 'utf8') } catch { continue } // it ended meanwhile
    const fields = stat.slice(stat.lastIndexOf(')') + 2).split(' ')
    children.set(fields[1], [...(children.get(fields[1]) ?? []), entry])
    ticks.set(entry, Number(fields[11]) + Number(fields[12]))
  }
  const sum = (process_id) => (ticks.get(process_id) ?? 0) + (children.get(process_id) ?? []).reduce((all, one) => all + sum(one), 0)
  return sum(String(root)) / 100
}

// Until the page may be read: scripts have run and the first picture is on the screen.
const seen = (page) => page.evaluate(() => new Promise((opened) => {
  requestAnimationFrame(() => requestAnimationFrame(() => opened(Math.round(performance.now()))))
}))
async function times_of(browser) {
  const said = []
  for (let i = 0; i < opens; ++i) {
    const page = await browser.newPage()
    await page.setViewport({ width: 1280, height: 900 })
    const before = cpu_of(browser.process().pid)
    await page.goto(url, { waitUntil: 'load', timeout: 120_000 })
    const seen_ms = await seen(page)
    const load_ms = await page.evaluate(() => performance.timing.loadEventEnd - performance.timing.navigationStart)
    said.push({ load: load_ms / 1000, seen: seen_ms / 1000, cpu: Number((cpu_of(browser.process().pid) - before).toFixed(2)) })
    await page.close()
  }
  return said
}

// In the page: what is wrong with how it is laid out.
function look() {
  const root = document.documentElement
  const said = { charts: 0, drawn: 0, sideways_px: Math.max(0, root.scrollWidth - root.clientWidth), clipped: [], overlapping: [] }
  said.charts = document.querySelectorAll("script[data-plot]").length
  said.drawn = Number(document.body.dataset.drawn || 0)
  for (const svg of document.querySelectorAll('.plot svg')) {
    const frame = svg.getBoundingClientRect()
    for (const text of svg.querySelectorAll('text')) {
      const box = text.getBoundingClientRect()
      if (!text.textContent || box.width === 0 || getComputedStyle(text).opacity === '0') continue
      if (box.left < frame.left - 1 || box.right > frame.right + 1 || box.top < frame.top - 1 || box.bottom > frame.bottom + 1)
        said.clipped.push(text.textContent)
    }
    for (const kind of ['.role-axis-label text', '.role-legend-label text', '.role-axis-title text, .role-legend-label text']) {
      const labels = [...svg.querySelectorAll(kind)].filter((text) => getComputedStyle(text).opacity !== '0')
      for (let i = 0; i < labels.length; ++i)
        for (let k = i + 1; k < labels.length; ++k) {
          const a = labels[i].getBoundingClientRect()
          const b = labels[k].getBoundingClientRect()
          if (Math.min(a.right, b.right) - Math.max(a.left, b.left) > 1 && Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top) > 2)
            said.overlapping.push(`${labels[i].textContent} | ${labels[k].textContent}`)
        }
    }
  }
  return said
}
function tables() {
  const all = {}
  for (const table of document.querySelectorAll('table[id]'))
    all[table.id] = [...table.rows].map((row) => [...row.cells].map((cell) => cell.textContent.trim()))
  return all
}

const browser = await puppeteer.launch({
  browser: 'chrome', executablePath: program, headless: true, userDataDir: profile, timeout: 180_000, protocolTimeout: 300_000,
  args: ['--no-sandbox', '--disable-gpu', '--no-first-run', '--disable-background-networking', '--disable-component-update', '--disable-sync']
})
const said = { page: pages[0], views: [], tables: {}, wrong: [] }
try {
  if (opens > 0) console.log(JSON.stringify(await times_of(browser)))
  const page = await browser.newPage()
  let view
  page.on('console', (message) => view.console.push(`${message.type()}: ${message.text()}`))
  page.on('pageerror', (error) => view.console.push(`error: ${error.message}`))
  page.on('request', (request) => {
    const address = request.url()
    if (address !== url && !address.startsWith('data:') && !address.startsWith('blob:')) view.elsewhere.push(address)
  })
  for (const width of opens > 0 ? [] : [1280, 390])
    for (const scheme of ['light', 'dark']) {
      view = { width, scheme, console: [], elsewhere: [] }
      await page.setViewport({ width, height: 900 })
      await page.emulateMediaFeatures([{ name: 'prefers-color-scheme', value: scheme }])
      await page.goto(url, { waitUntil: 'load', timeout: 120_000 })
      view.opened_ms = await seen(page)
      const drawn = "Number(document.body.dataset.drawn || 0) >= document.querySelectorAll('script[data-plot]').length"
      await page.waitForFunction(drawn, { timeout: 1000 * Number(options.wait) }).catch(() => {})
      await page.evaluate(() => document.querySelectorAll('details').forEach((one) => { if (!one.closest('.plot')) one.open = true }))
      Object.assign(view, await page.evaluate(look))
      if (options.pictures) await page.screenshot({ path: join(options.pictures, `${width}-${scheme}.png`), fullPage: true })
      said.views.push(view)
      const where = `${width} pixels wide, ${scheme}`
      if (view.drawn !== view.charts) said.wrong.push(`${where}: ${view.drawn} of ${view.charts} charts are drawn`)
      if (view.sideways_px > 0) said.wrong.push(`${where}: scrolls sideways by ${view.sideways_px} pixels`)
      for (const name of ['console', 'elsewhere', 'clipped', 'overlapping'])
        if (view[name].length) said.wrong.push(`${where}: ${name}: ${view[name].slice(0, 5).join('; ')}`)
    }
  said.tables = await page.evaluate(tables)
} finally {
  await browser.close()
  rmSync(profile, { recursive: true, force: true })
}
if (opens === 0) console.log(JSON.stringify(said, null, 1))
process.exit(said.wrong.length ? 1 : 0)

// Decodes a clip in a real browser, frame by frame: seeks to the middle of each frame's time, draws it to a canvas, and
// says how many there are, how many of them differ, and the duration.
//
//   node frame_check.mjs URL CLIP FPS [--browser chromium|firefox]    URL: of a server that has the path CLIP
import { mkdtempSync, rmSync } from 'node:fs'
import { tmpdir } from 'node:os'
import { join } from 'node:path'
import { parseArgs } from 'node:util'
import puppeteer from 'puppeteer-core'

const { values, positionals: [url, clip, fps] } = parseArgs({
  allowPositionals: true, options: { browser: { type: 'string', default: 'chromium' } }
})
const profile = mkdtempSync(join(tmpdir(), 'frame-check-'))
const browser = await puppeteer.launch(values.browser === 'firefox'
  ? { browser: 'firefox', executablePath: '/usr/bin/firefox-esr', headless: true, userDataDir: profile }
  : {
      executablePath: '/usr/bin/chromium', headless: true, userDataDir: profile,
      args: ['--no-sandbox', '--disable-gpu', '--disable-quic', '--no-first-run', '--disable-background-networking',
        '--disable-component-update', '--disable-sync']
    })
try {
  const page = await browser.newPage()
  await page.goto(new URL('consent.md', url).href)
  console.log(JSON.stringify(await page.evaluate(async (source, rate) => {
    const video = document.createElement('video')
    video.muted = true
    video.preload = 'auto'
    video.src = URL.createObjectURL(await (await fetch(source)).blob())
    await new Promise((resolve, reject) => {
      video.onloadeddata = resolve
      video.onerror = () => reject(new Error(video.error?.message))
    })
    const canvas = document.createElement('canvas')
    canvas.width = video.videoWidth
    canvas.height = video.videoHeight
    const context = canvas.getContext('2d', { willReadFrequently: true })
    const seen = []
    for (let i = 0; (i + 0.5) / rate < video.duration; ++i) {
      const there = new Promise((resolve) => { video.onseeked = resolve })
      video.currentTime = (i + 0.5) / rate
      await there
      context.drawImage(video, 0, 0)
      const { data } = context.getImageData(0, 0, canvas.width, canvas.height)
      let sum = 2166136261
      for (const each of data) sum = Math.imul(sum ^ each, 16777619) >>> 0
      seen.push(sum)
    }
    return { duration: video.duration, frames: seen.length, different: new Set(seen).size }
  }, `/${clip}`, Number(fps))))
} finally {
  await browser.close()
  rmSync(profile, { recursive: true, force: true })
}

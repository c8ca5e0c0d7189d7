// Screen: what happens to the window (hidden, resized, zoomed, full screen), and how large a degree of the visual field is
// on it.
(function () {
  'use strict'

  // ---- the window

  // Events since begin(): [{ms, what, ...}], at most kMostEvents of them; `hidden` counts on.
  const kMostEvents = 50
  const log = { from: 0, events: [], hidden: 0, hiddenMs: 0, hiddenSince: null, exits: 0 }
  const note = (what, more) => {
    if (log.events.length < kMostEvents) log.events.push({ ms: Math.round(performance.now() - log.from), what, ...more })
  }
  const size = () => ({
    width: window.innerWidth, height: window.innerHeight, pixel_ratio: window.devicePixelRatio,
    zoom: window.visualViewport?.scale ?? 1
  })
  document.addEventListener('visibilitychange', () => {
    if (document.hidden) {
      ++log.hidden
      log.hiddenSince = performance.now()
      note('hidden')
    } else {
      if (log.hiddenSince !== null) log.hiddenMs += performance.now() - log.hiddenSince
      log.hiddenSince = null
      note('shown')
    }
  })
  window.addEventListener('blur', () => note('unfocused'))
  window.addEventListener('resize', () => note('resized', size()))
  window.visualViewport?.addEventListener('resize', () => note('zoomed', size()))
  document.addEventListener('fullscreenchange', () => {
    if (!document.fullscreenElement) ++log.exits
    note(document.fullscreenElement ? 'full screen' : 'left full screen')
  })

  Study.window = {
    size,
    begin() { Object.assign(log, { from: performance.now(), events: [], hidden: 0, hiddenMs: 0, exits: 0 }) },
    since() {
      return {
        hidden: log.hidden, hidden_ms: Math.round(log.hiddenMs), full_screen: Boolean(document.fullscreenElement),
        full_screen_exits: log.exits, window: size(), events: log.events.slice()
      }
    }
  }

  // Called from a click or a key. What became of it, in a word.
  Study.fullScreen = async () => {
    if (document.fullscreenElement) return 'already'
    if (!document.documentElement.requestFullscreen) return 'not offered'
    try {
      await document.documentElement.requestFullscreen({ navigationUI: 'hide' })
      return 'entered'
    } catch {
      return 'refused'
    }
  }

  // ---- calibration

  // A bank card's width, ISO/IEC 7810 ID-1.
  const kCardMm = 85.6
  // Where the blind spot begins, seen from the point that is looked at, and how much that differs between people: Li, Joo,
  // Yeatman and Reinecke, "Controlling for participants' viewing distance in large-scale, psychophysical online experiments
  // using a virtual chinrest" (2020), use 13.5 degrees; Rohrschneider, "Determination of the location of the fovea on the
  // fundus" (2004), finds a standard deviation of 1.1 degrees of the horizontal distance between fovea and optic disc.
  const kBlindSpotDeg = 13.5
  const kBlindSpotSdDeg = 1.1
  const kCardRounds = 3
  const kSpotRounds = 5
  // What the server and the analysis take (core/screen_calibration.h).
  const kLeastPixelsPerDegree = 5
  const kMostPixelsPerDegree = 500
  const kSpotSpeed = 120  // CSS pixels a second

  // cards: widths of the card as fitted; spots: how far from the fixation the dot vanished; both in CSS pixels.
  //
  // The distance of the eye is D = s / (p tan a), s the spot in pixels, p pixels by millimetre, a the angle; a degree is
  // 2 D tan(0.5 deg) p pixels = 2 tan(0.5 deg) s / tan a. The card cancels out of pixels per degree: its error is one of
  // the distance in millimetres alone, and the spread of blind spots between people dominates both.
  Study.calibration = (cards, spots) => {
    const rad = Math.PI / 180
    const angle = kBlindSpotDeg * rad
    const out = {
      card_px: cards, blind_spot_px: spots, px_per_mm: null, px_per_mm_se: null, distance_mm: null, distance_mm_se: null,
      pixels_per_degree: null, pixels_per_degree_se: null
    }
    const card = cards.length > 1 ? Study.standardError(cards) / Study.mean(cards) : null
    if (cards.length > 1) {
      out.px_per_mm = Study.mean(cards) / kCardMm
      out.px_per_mm_se = card * out.px_per_mm
    }
    if (spots.length < 2) return out
    const spot = Study.standardError(spots) / Study.mean(spots)
    const eyes = (kBlindSpotSdDeg * rad) / (Math.sin(angle) * Math.cos(angle))
    const perDegree = 2 * Math.tan(0.5 * rad) * Study.mean(spots) / Math.tan(angle)
    const error = perDegree * Math.hypot(spot, eyes)
    // Else a key was held down, and there is no blind spot.
    if (!(perDegree >= kLeastPixelsPerDegree && perDegree <= kMostPixelsPerDegree && error <= perDegree)) return out
    out.pixels_per_degree = perDegree
    out.pixels_per_degree_se = error
    if (card !== null) {
      out.distance_mm = Study.mean(spots) / out.px_per_mm / Math.tan(angle)
      out.distance_mm_se = out.distance_mm * Math.hypot(spot, eyes, card)
    }
    return out
  }

  // jsPsych plugin: the card, then the blind spot.
  class CalibrationPlugin {
    static info = { name: 'crowdbench-calibration', version: '1.0.0', parameters: {}, data: {} }
    constructor(jsPsych) { this.jsPsych = jsPsych }

    async trial(display) {
      const cards = await this.cards(display)
      const spots = await this.spots(display)
      display.innerHTML = ''
      this.jsPsych.finishTrial({ ...Study.calibration(cards, spots), ...size() })
    }

    // Each round begins at another width, so that nobody repeats the last one.
    async cards(display) {
      const widths = []
      const most = Math.max(160, Math.min(900, window.innerWidth - 40))
      for (let round = 0; round < kCardRounds; ++round) {
        const from = Math.round(most * (0.25 + 0.5 * ((round * 0.618 + 0.3) % 1)))
        display.innerHTML = `<div class="text"><h1>How large is your screen?</h1>
          <p id="how">Hold a bank card, or any card of that size, flat against the screen. Make the rectangle below as wide as
          the card with the slider or the arrow keys.</p>
          <div id="card" style="width: ${from}px" role="presentation"></div>
          <p><label>Width <input type="range" id="width" min="100" max="${most}" value="${from}" aria-describedby="how"></label></p>
          <p class="count">${round + 1} of ${kCardRounds}</p>
          <p class="buttons"><button type="button" id="fits">It fits</button>
          <button type="button" id="skip" class="quiet">I have no card</button></p></div>`
        const slider = display.querySelector('#width')
        slider.addEventListener('input', () => { display.querySelector('#card').style.width = `${slider.value}px` })
        slider.focus()
        const chosen = await new Promise((resolve) => {
          display.querySelector('#fits').addEventListener('click', () => resolve(Number(slider.value)))
          display.querySelector('#skip').addEventListener('click', () => resolve(null))
        })
        if (chosen === null) return []
        widths.push(chosen)
      }
      return widths
    }

    async spots(display) {
      const distances = []
      for (let round = 0; round < kSpotRounds; ++round) {
        display.innerHTML = `<div class="text"><h1>How far away are you?</h1>
          <ol><li>Sit as you will sit during the study. Close or cover your <strong>right</strong> eye.</li>
          <li>Look at the square with your left eye all the time. Begin with the space bar or the button.</li>
          <li>A red dot moves to the left. Press again in the moment when you no longer see it. If you see it all the way to
          the edge, this window is too narrow: choose <em>I cannot do this</em>.</li></ol>
          <div id="field"><div id="dot" hidden></div><div id="square"></div></div>
          <p class="count">${round + 1} of ${kSpotRounds}</p>
          <p class="buttons"><button type="button" id="press">Begin</button>
          <button type="button" id="skip" class="quiet">I cannot do this</button></p></div>`
        const distance = await this.spot(display)
        if (distance === null) return []
        distances.push(distance)
      }
      return distances
    }

    // How far from the square the dot was when the participant pressed; null where they give up.
    spot(display) {
      const field = display.querySelector('#field')
      const dot = display.querySelector('#dot')
      const button = display.querySelector('#press')
      button.focus()
      return new Promise((resolve) => {
        let began = null
        let distance = 0
        const reach = () => field.clientWidth - 40
        const move = (now) => {
          if (began === null) return
          distance = ((now - began) / 1000 * kSpotSpeed) % reach()
          dot.style.right = `${20 + distance}px`
          requestAnimationFrame(move)
        }
        const end = (value) => {
          began = null
          document.removeEventListener('keydown', key)
          resolve(value)
        }
        const press = () => {
          if (began !== null) return distance > 20 ? end(distance) : undefined
          began = performance.now()
          dot.hidden = false
          button.textContent = 'It is gone'
          requestAnimationFrame(move)
        }
        const key = (event) => {
          if (event.key !== ' ' || event.target.id === 'skip' || event.target.id === 'leave') return
          if (document.querySelector('dialog[open]')) return
          event.preventDefault()
          if (!event.repeat) press()
        }
        document.addEventListener('keydown', key)
        button.addEventListener('click', press)
        display.querySelector('#skip').addEventListener('click', () => end(null))
      })
    }
  }
  Study.CalibrationPlugin = CalibrationPlugin
})()

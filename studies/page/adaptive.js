// Adaptive: which stimulus a trial shows, chosen by the participant's own answers so far. The same rule as
// studies/plan/adaptive.h, step by step; a test holds both to the same choices.
//
// Based on: Watson, "QUEST+" (2017); Bradley and Terry (1952) with Lindley's expected information (1956) for pairs.
(function () {
  'use strict'

  const kEqual = 1e-9  // nats: of choices that tell equally much, rounding must not choose

  const xlogx = (x) => (x > 0 ? x * Math.log(x) : 0)
  const logistic = (x) => 1 / (1 + Math.exp(-x))
  const entropy = (p) => (p > 0 && p < 1 ? -p * Math.log(p) - (1 - p) * Math.log1p(-p) : 0)

  // The standard normal distribution: the series of the error function near 0, its continued fraction in the tail.
  function normalCdf(x) {
    const z = Math.abs(x) / Math.SQRT2
    let tail
    if (z < 2.5) {
      let term = z
      let sum = z
      for (let n = 1; Math.abs(term) > 1e-18 * sum; ++n) {
        term *= (2 * z * z) / (2 * n + 1)
        sum += term
      }
      tail = (1 - (2 / Math.sqrt(Math.PI)) * Math.exp(-z * z) * sum) / 2
    } else {
      let fraction = z
      for (let n = 80; n > 0; --n) fraction = z + n / 2 / fraction
      tail = Math.exp(-z * z) / Math.sqrt(Math.PI) / fraction / 2
    }
    return x < 0 ? tail : 1 - tail
  }

  function curveAt(curve, x, threshold, slope) {
    if (curve === 'cumgauss') return normalCdf((x - threshold) / slope)
    if (curve === 'weibull') return -Math.expm1(-Math.pow(x / threshold, slope))
    return logistic((x - threshold) / slope)
  }

  // The grid's points, the last parameter fastest, and what a level's answers tell of them.
  class Quest {
    constructor(rule) {
      this.points = []
      for (const threshold of rule.threshold)
        for (const slope of rule.slope)
          for (const guess of rule.guess)
            for (const lapse of rule.lapse) this.points.push({ threshold, slope, guess, lapse })
      this.yes = rule.choices.map(({ level }) => this.points.map((p) => {
        const rising = curveAt(rule.curve, level, p.threshold, p.slope)
        return p.guess + (1 - p.guess - p.lapse) * (rule.falling ? 1 - rising : rising)
      }))
      this.own = this.yes.map((row) => row.map((p) => xlogx(p) + xlogx(1 - p)))
      this.forget()
    }
    forget() { this.posterior = this.points.map(() => 1 / this.points.length) }
    // choice: -1 where there was nothing to see. An answer that no point of the grid allows tells nothing.
    answer(choice, yes) {
      let total = 0
      const after = this.posterior.map((before, i) => {
        const p = choice < 0 ? this.points[i].guess : this.yes[choice][i]
        const now = before * (yes ? p : 1 - p)
        total += now
        return now
      })
      if (total > 0) this.posterior = after.map((p) => p / total)
    }
    // By choice, minus the entropy that is expected to be left after its answer.
    worths() {
      const logs = this.posterior.map((p) => (p > 0 ? Math.log(p) : 0))
      return this.yes.map((row, choice) => {
        let yes = 0
        let sum = 0
        for (let i = 0; i < row.length; ++i) {
          yes += this.posterior[i] * row[i]
          sum += this.posterior[i] * (logs[i] + this.own[choice][i])
        }
        return sum - xlogx(yes) - xlogx(1 - yes)
      })
    }
  }

  // Of a symmetric, positive definite matrix, by Gauss and Jordan.
  function inverse(matrix) {
    const n = matrix.length
    const rows = matrix.map((row, i) => [...row, ...row.map((_, j) => (i === j ? 1 : 0))])
    for (let i = 0; i < n; ++i) {
      const pivot = rows[i][i]
      for (let k = 0; k < 2 * n; ++k) rows[i][k] /= pivot
      for (let j = 0; j < n; ++j) {
        const by = rows[j][i]
        if (j === i || by === 0) continue
        for (let k = 0; k < 2 * n; ++k) rows[j][k] -= by * rows[i][k]
      }
    }
    return rows.map((row) => row.slice(n))
  }

  // Log-worths of the items after these answers, {a, b, won}: their mode, and the inverse of the curvature there.
  function belief(answers, items, sd) {
    const precision = 1 / (sd * sd)
    const mean = new Array(items).fill(0)
    let covariance
    for (let step = 0; step < 100; ++step) {
      const gradient = mean.map((w) => -precision * w)
      const information = mean.map((_, i) => mean.map((__, j) => (i === j ? precision : 0)))
      for (const { a, b, won } of answers) {
        const p = logistic(mean[a] - mean[b])
        gradient[a] += won - p
        gradient[b] -= won - p
        const weight = p * (1 - p)
        information[a][a] += weight
        information[b][b] += weight
        information[a][b] -= weight
        information[b][a] -= weight
      }
      covariance = inverse(information)
      const move = covariance.map((row) => row.reduce((sum, c, j) => sum + c * gradient[j], 0))
      const longest = Math.max(...move.map(Math.abs))
      if (longest < 1e-12) break
      for (let i = 0; i < items; ++i) mean[i] += move[i] * (longest > 1 ? 1 / longest : 1)
    }
    return { mean, covariance }
  }

  function expectedInformation({ mean, covariance: c }, a, b) {
    const middle = mean[a] - mean[b]
    const sd = Math.sqrt(Math.max(0, c[a][a] + c[b][b] - 2 * c[a][b]))
    let total = 0
    let yes = 0
    let known = 0
    for (let k = 0; k < 41; ++k) {
      const z = 5 * (2 * k / 40 - 1)
      const weight = Math.exp(-z * z / 2)
      const p = logistic(middle + sd * z)
      total += weight
      yes += weight * p
      known += weight * entropy(p)
    }
    return entropy(yes / total) - known / total
  }

  class Adaptive {
    // rule: trials.json's `adaptive`; study: the plan's hash.
    constructor(rule, study) {
      this.rule = rule
      this.study = study
      this.choices = new Map(rule.choices.flatMap(({ stimuli }, c) => stimuli.map((stimulus) => [stimulus, c])))
    }
    // The table of a grid takes a good part of a second, and is the same for all trials.
    get quest() { return (this.grid ??= new Quest(this.rule)) }
    get stimuli() { return [...this.choices.keys()] }

    worths(before) {
      const { rule } = this
      if (rule.method === 'active-pairs') {
        const answers = before.map(({ stimulus, answer }) => {
          const { a, b } = rule.choices[this.choices.get(stimulus)]
          return { a, b, won: answer === 'cannot-tell' ? 0.5 : answer === rule.yes[stimulus] ? 1 : 0 }
        })
        const now = belief(answers, rule.items, rule.worth_sd)
        return rule.choices.map(({ a, b }) => expectedInformation(now, a, b))
      }
      const { quest } = this
      quest.forget()
      for (const { stimulus, answer } of before)
        quest.answer(this.choices.get(stimulus) ?? -1, answer === rule.yes[stimulus])
      return quest.worths()
    }

    // The stimulus of a trial. before: the participant's answers to main trials, {stimulus, answer}, in the list's order.
    choose(list, trial, before) {
      const place = `${this.study}/${list}/${trial}/`
      const worths = this.worths(before)
      const best = Math.max(...worths)
      const first = (names, name) => names.map((each) => [Study.sha256(place + name(each)), each])
        .reduce((a, b) => (b[0] < a[0] ? b : a))[1]
      const choice = first([...worths.keys()].filter((c) => worths[c] >= best - kEqual), (c) => c)
      const shown = (stimulus) => before.filter((each) => each.stimulus === stimulus).length
      const { stimuli } = this.rule.choices[choice]
      const least = Math.min(...stimuli.map(shown))
      return first(stimuli.filter((stimulus) => shown(stimulus) === least), (stimulus) => stimulus)
    }
  }

  Study.Adaptive = Adaptive
})()

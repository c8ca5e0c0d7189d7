// Session: who takes part, what was answered, and how that reaches the server.
//
// Whatever was answered is written to the browser's own storage before anything else happens, and stays there until the
// server has acknowledged it: a reload, a crash or a lost connection costs at most the trial on screen. Where no server
// of ours is (the folder on any static server), the browser's storage is all there is, and the page offers the answers as
// files at the end.
(function () {
  'use strict'

  const notice = (text) => { document.getElementById('notice').textContent = text }
  const sleep = (ms) => new Promise((wake) => setTimeout(wake, ms))

  // The browser's storage, or memory where it refuses.
  const memory = new Map()
  const keep = (key, value, where = 'localStorage') => {
    memory.set(key, value)
    try { window[where].setItem(key, value) } catch { return false }
    return true
  }
  const kept = (key, where = 'localStorage') => {
    try { return window[where].getItem(key) ?? memory.get(key) ?? null } catch { return memory.get(key) ?? null }
  }
  const forget = (key) => {
    memory.delete(key)
    for (const where of ['localStorage', 'sessionStorage']) {
      try { window[where].removeItem(key) } catch { /* there was none to remove it from */ }
    }
  }

  const random = () => Array.from(crypto.getRandomValues(new Uint8Array(16)), (b) => b.toString(16).padStart(2, '0')).join('')

  class Session {
    // study: the plan's hash.
    constructor(study) {
      this.study = study
      this.here = `crowdbench/${study}/who`
      const query = new URLSearchParams(window.location.search)
      const named = query.get('PROLIFIC_PID') ?? query.get('participant')
      this.wanted = query.get('list')
      // The platform's names of study and session are of no use here, and the participant's is kept as a hash alone: none
      // stays in the address, in the history or in anything that is sent.
      this.participant = named ? Study.sha256(`${study}/${named}`) : kept(this.here, 'sessionStorage') ?? kept(this.here)
      if (!this.participant) this.participant = Study.sha256(`${study}/${random()}`)
      if (window.location.search) history.replaceState(null, '', window.location.pathname)
      keep(this.here, this.participant, 'sessionStorage')
      keep(this.here, this.participant)
      this.key = `crowdbench/${study}/${this.participant}`
      const before = kept(this.key)
      this.state = before ? JSON.parse(before)
        : { list: null, token: null, items: [], given: {}, outbox: [], rows: [], begun: {}, consented: false, finished: false }
      this.state.given ??= {}  // kept by an earlier page
      this.served = false
      this.sending = null
      this.taken = false
      this.whenTaken = () => {}  // another window has taken over
    }

    save() {
      this.safe = keep(this.key, JSON.stringify(this.state))
      return this.safe
    }
    has(item) { return this.state.items.includes(item) }
    // Which stimulus a trial showed and what was answered; undefined before.
    given(item) { return this.state.given[item] }
    // "screen-2": the first number that was not sent before.
    next(page) {
      let number = 1
      while (this.has(`${page}-${number}`)) ++number
      return `${page}-${number}`
    }
    // A trial is about to be shown; how often it was before.
    begin(item) {
      const before = this.state.begun[item] ?? 0
      this.state.begun[item] = before + 1
      // The server remembers it for whoever goes on in another browser, at another address or after this one lost its storage.
      if (this.served) this.state.outbox.push(JSON.stringify({ item, kind: 'begin', begun: before + 1 }))
      this.save()
      this.send()
      return before
    }

    async ask(path, body) {
      const headers = { 'Content-Type': 'application/json' }
      if (this.state.token) headers['X-Study-Token'] = this.state.token
      const response = await fetch(path, { method: 'POST', headers, body, cache: 'no-store' })
      const said = await response.json().catch(() => ({}))
      return { status: response.status, said }
    }

    // Whether a server of ours shows the page. Throws where the network fails.
    async find() {
      const response = await fetch('api/study', { cache: 'no-store' })
      const said = response.ok ? await response.json().catch(() => null) : null
      this.served = said?.crowdbench === 1
      if (this.served && said.study !== this.study) throw new Error('the server shows another study')
    }

    // The participant's list, new or as before; `lists`: all ids.
    async start(lists) {
      if (!this.served) {
        if (!this.state.list) {
          const asked = lists.includes(this.wanted) ? this.wanted : null
          this.state.list = asked ?? lists[parseInt(this.participant.slice(0, 8), 16) % lists.length]
        }
        this.save()
        return
      }
      const body = { study: this.study, participant: this.participant }
      if (lists.includes(this.wanted)) body.list = this.wanted
      const { status, said } = await this.ask('api/start', JSON.stringify(body))
      if (status !== 200) throw new Error(said.error ?? `the server answers ${status}`)
      this.state.token = said.token
      this.state.list = said.list
      this.state.finished = said.state === 'finished'
      for (const [item, count] of Object.entries(said.begun ?? {})) this.state.begun[item] = Math.max(count, this.state.begun[item] ?? 0)
      const waiting = this.state.outbox.map((text) => JSON.parse(text)).filter(({ kind }) => kind !== 'begin').map(({ item }) => item)
      this.state.items = [...new Set([...said.items, ...waiting])]
      // What was answered in another browser; of what is still on its way this one knows better.
      const here = Object.entries(this.state.given).filter(([item]) => waiting.includes(item))
      this.state.given = { ...said.given, ...Object.fromEntries(here) }
      this.save()
      this.send()
    }

    // A record of one item: kept here at once, sent in the background. Where a program drives the browser, its observer is
    // simulated, and every record says so.
    add(row) {
      const text = JSON.stringify(window.navigator?.webdriver === true ? { ...row, observers: 'simulated' } : row)
      this.state.items.push(row.item)
      if (row.answer !== undefined) this.state.given[row.item] = { stimulus: row.stimulus, answer: row.answer }
      if (this.served) this.state.outbox.push(text)
      else this.state.rows.push(text)
      if (!this.save()) notice('This browser keeps nothing. Do not reload the page before you have finished.')
      this.send()
    }

    // Sends what waits, oldest first, until nothing does or another window has taken over.
    send() {
      if (this.served && !this.sending) this.sending = this.empty().finally(() => { this.sending = null })
      return this.sending ?? Promise.resolve()
    }
    async empty() {
      for (let failures = 0; this.state.outbox.length > 0 && !this.taken;) {
        const text = this.state.outbox[0]
        const status = await this.ask('api/answer', text).then((got) => got.status, () => 0)
        if (status === 401) {
          this.taken = true
          this.whenTaken()
        } else if (![200, 400, 409, 413].includes(status)) {
          // Lost, or answered by what stands between (a proxy that is busy): the server has not refused it.
          notice('Your answer is kept in this browser, and not yet at the server. Trying again.')
          await sleep(Math.min(10000, 500 * 2 ** failures++))
        } else {
          // Kept; or refused, which it would be the next time too.
          if (status !== 200 && status !== 409) notice(`The server refused an answer (${status}). Please tell who invited you.`)
          if (this.state.outbox[0] === text) this.state.outbox.shift()
          this.save()
          if (failures > 0 && status === 200) notice('')
          failures = 0
        }
      }
    }

    async finish() {
      await this.send()
      if (this.served && !this.taken) {
        for (let wait = 500; ; wait *= 2) {
          const status = await this.ask('api/finish', '{}').then((got) => got.status, () => 0)
          if (status === 200) break
          if (status === 401) {
            this.taken = true
            this.whenTaken()
            return
          }
          if (status === 409) throw new Error('The server has not got all your answers')
          notice('The server does not answer. Please leave this window open.')
          await sleep(Math.min(wait, 10000))
        }
        notice('')
      }
      this.state.finished = true
      this.save()
      // The next to sit down at this computer is somebody else; a reload of this window is not.
      forget(this.here)
      keep(this.here, this.participant, 'sessionStorage')
    }

    async withdraw() {
      this.taken = true  // nothing that waits is sent any more
      if (this.served && this.state.token) {
        const { status } = await this.ask('api/withdraw', '{}')
        if (status !== 200 && status !== 401) throw new Error('the server does not answer')
      }
      forget(this.key)
      forget(this.here)
    }

    rows() { return this.state.rows.map((text) => JSON.parse(text)) }
  }

  Study.Session = Session
  Study.notice = notice
  Study.sleep = sleep
})()

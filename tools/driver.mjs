// For the other scripts here: asks the driver for JSON. `answers`: the exit statuses that are answers. Where it fails, what
// it says and the command go to stderr, and the status is 2.
import { execFileSync } from 'node:child_process'

export const asks = (driver, answers = [0]) => (...args) => {
  try {
    return JSON.parse(execFileSync(driver, [...args, '--json'], { maxBuffer: 1 << 28, stdio: ['ignore', 'pipe', 'pipe'] }))
  } catch (error) {
    if (answers.includes(error.status)) return JSON.parse(error.stdout)
    const said = String(error.stderr ?? '').trim().split('\n').pop()
    console.error(`${said ? said + '\n' : ''}failed (${error.status ?? error.message}): ${[driver, ...args].join(' ')} --json`)
    process.exit(2)
  }
}

// Prints the quality tables of renderers/relief/README.md as Markdown.
// Usage: node tools/relief_quality.mjs build/release/bin/crowdbench [FOLDER_OF_CHARACTERS] [REPRESENTATION [HEIGHTS]]
// (about four minutes)
import { execFileSync } from 'node:child_process';
import { existsSync } from 'node:fs';

const [driver, folder, representation = 'relief', tall = '30,60,120,240,480'] = process.argv.slice(2);
if (!driver) {
  console.error('usage: relief_quality.mjs DRIVER [FOLDER [REPRESENTATION [HEIGHTS]]]');
  process.exit(2);
}
const characters = [['mannequin', 'walk'], ['mannequin:joints=53', 'walk']];
for (const [file, clip] of [['CesiumMan.glb', '0'], ['KayKitKnight.glb', 'Walking_A'], ['Robot.glb', 'Robot_Walking']])
  if (folder && existsSync(`${folder}/${file}`)) characters.push([`${folder}/${file}`, clip]);
const heights = tall.split(',').map(Number);
const views = [['front', '0', '0'], ['side', '90', '0'], ['three-quarter', '45', '0'], ['above', '45', '45']];

console.log('| character | view | ' + heights.map((h) => `${h} px`).join(' | ') + ' |');
console.log('|---|---|' + heights.map(() => '---').join('|') + '|');
for (const [character, clip] of characters) {
  for (const [name, azimuth, elevation] of views) {
    const { rows } = JSON.parse(execFileSync(driver, ['quality', '--representation', representation, '--character', character,
      '--clip', clip, '--time', '0.1,0.25,0.4,0.6', '--height-px', heights.join(','), '--azimuth-deg', azimuth,
      '--elevation-deg', elevation, '--json'], { stdio: ['ignore', 'pipe', 'ignore'], maxBuffer: 1 << 26 }));
    const cells = heights.map((h) => {
      const some = rows.filter((r) => r.height_px === h);
      const mean = (key) => (some.reduce((sum, r) => sum + r[key], 0) / some.length).toFixed(3);
      return `${mean('silhouette_iou')} / ${mean('ssim')}`;
    });
    console.log(`| ${character.replace(/.*\//, '').replace('.glb', '')} | ${name} | ${cells.join(' | ')} |`);
  }
}

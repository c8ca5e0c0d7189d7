// Prints the quality tables of renderers/relief/README.md as Markdown.
// Usage: node tools/relief_quality.mjs build/release/bin/crowdbench [FOLDER_OF_CHARACTERS] [REPRESENTATION [HEIGHTS]]
//        node tools/relief_quality.mjs build/release/bin/crowdbench --tiny
// (about four minutes; --tiny: one small character and one moment, to see that it runs)
import { existsSync } from 'node:fs';
import { asks } from './driver.mjs';

const [driver, ...rest] = process.argv.slice(2);
const tiny = rest[0] === '--tiny';
const [folder, representation = 'relief', tall = '30,60,120,240,480'] =
  tiny ? [undefined, 'relief:map=32,capture=bind', '30'] : rest;
if (!driver || (tiny && rest.length > 1)) {
  console.error('usage: relief_quality.mjs DRIVER [FOLDER [REPRESENTATION [HEIGHTS]] | --tiny]');
  process.exit(2);
}
const characters = tiny ? [['mannequin:triangles=500', 'walk']] : [['mannequin', 'walk'], ['mannequin:joints=53', 'walk']];
const ask = asks(driver);
const times = tiny ? '0.1' : '0.1,0.25,0.4,0.6';
for (const [file, clip] of [['CesiumMan.glb', '0'], ['KayKitKnight.glb', 'Walking_A'], ['Robot.glb', 'Robot_Walking']])
  if (folder && existsSync(`${folder}/${file}`)) characters.push([`${folder}/${file}`, clip]);
const heights = tall.split(',').map(Number);
const views = [['front', '0', '0'], ['side', '90', '0'], ['three-quarter', '45', '0'], ['above', '45', '45']];

console.log('| character | view | ' + heights.map((h) => `${h} px`).join(' | ') + ' |');
console.log('|---|---|' + heights.map(() => '---').join('|') + '|');
for (const [character, clip] of characters) {
  for (const [name, azimuth, elevation] of views) {
    const { rows } = ask('quality', '--representation', representation, '--character', character,
      '--clip', clip, '--time', times, '--height-px', heights.join(','), '--azimuth-deg', azimuth,
      '--elevation-deg', elevation);
    const cells = heights.map((h) => {
      const some = rows.filter((r) => r.height_px === h);
      const mean = (key) => (some.reduce((sum, r) => sum + r[key], 0) / some.length).toFixed(3);
      return `${mean('silhouette_iou')} / ${mean('ssim')}`;
    });
    console.log(`| ${character.replace(/.*\//, '').replace('.glb', '')} | ${name} | ${cells.join(' | ')} |`);
  }
}

// Drives the page of a running loop in a headless Chromium: node page.mjs ADDRESS [PICTURE]. Prints what it measures, and a line that
// begins with FAILED for what does not hold.
import fs from 'node:fs';
import {axeSource, checks, open} from './browser.mjs';

const [address, picture] = process.argv.slice(2);
const kPatience = {timeout: 10000};

const {browser, page, faults} = await open(address);
const text = selector => page.textContent(selector);
const {check, contains, finish} = checks(page);
/** The numbers that the page shows of a node. */
const numbers = name => page.evaluate(node => {
  const row = [...document.querySelectorAll('#nodes tr')].find(each => each.firstChild.textContent === node);
  return row ? [...row.children].slice(2).map(cell => Number(cell.textContent.replaceAll(',', ''))) : [];
}, name);
/** The part of a canvas' pixels that changes within a second. */
const pixels = selector => page.evaluate(where => {
  const canvas = document.querySelector(where);
  const copy = document.createElement('canvas');
  [copy.width, copy.height] = [canvas.width, canvas.height];
  const context = copy.getContext('2d');
  context.drawImage(canvas, 0, 0);
  return [...context.getImageData(0, 0, copy.width, copy.height).data].reduce((sum, value, i) => (sum + value * (i % 997 + 1)) % 1e9, 0);
}, selector);

// Live data.
await contains('#bridge', 'running');
for (const node of ['bridge', 'controller', 'page', 'robot_sim', 'vision']) await contains('#nodes', node);
await contains('#reach', 'target ball');
await contains('#reach', 'mm away');
await contains('#rates', 'joint command');
const plots = await page.locator('#plots canvas').count();
check(plots === 8, `there are ${plots} plots, not eight`);
const sentBefore = (await numbers('bridge'))[5];
await page.waitForFunction(before => {
  const row = [...document.querySelectorAll('#nodes tr')].find(each => each.firstChild.textContent === 'bridge');
  return Number(row.lastChild.textContent.replaceAll(',', '')) > before;
}, sentBefore, kPatience).catch(() => check(false, 'the counters stand still'));
const before = await pixels('#picture');
await page.waitForTimeout(1000);
check(before !== 0 && before !== await pixels('#picture'), 'the picture of the cameras does not change');

// Frames and script, under software rendering.
const rates = [], scripts = [];
for (let i = 0; i < 4; ++i) {
  await page.waitForTimeout(1000);
  const {framesPerS, scriptMs} = await page.evaluate(() => ({...document.documentElement.dataset}));
  rates.push(Number(framesPerS));
  scripts.push(Number(scriptMs));
}
console.log(`frames/s: ${rates.join(', ')}; script: ${scripts.join(', ')} ms a frame`);

// Pause, resume, slow down, and what is refused.
await page.keyboard.press('p');
await contains('#answer', 'pause: done');
await contains('#bridge', 'paused');
await page.click('#resume');
await contains('#answer', 'resume: done');
await page.focus('#speed');
await page.keyboard.press('ArrowLeft');
await contains('#answer', 'speed: done');
await contains('#bridge', 'at 95 %');
await page.keyboard.press('r');
await contains('#answer', 'reset: refused');

// Space stops, although the slider has the focus; enabling goes on.
const pressed = Date.now();
await page.keyboard.press('Space');
await contains('#bridge', 'idle');
console.log(`from the key to the page's word that the arm is stopped: ${Date.now() - pressed} ms`);
await contains('#answer', 'stop: done');
check(await page.inputValue('#speed') === '95', 'space moved the slider');
await page.focus('#enable');
await page.keyboard.press('Space');
await contains('#answer', 'stop: done');
await page.keyboard.press('e');
await contains('#answer', 'enable: done');
await contains('#bridge', 'running');
await page.focus('#speed');
await page.keyboard.press('End');
await contains('#bridge', 'running');

// The menu of plots closes by Escape, and gives the focus back.
await page.click('.menu summary');
await page.focus('#plot-choice input');
await page.keyboard.press('Escape');
check(await page.evaluate(() => !document.querySelector('.menu').open && document.activeElement.tagName === 'SUMMARY'), 'Escape does not close the menu of plots');

// Accessible, in light and dark.
await page.addScriptTag({path: axeSource}).catch(() => {});
if (!await page.evaluate(() => 'axe' in window)) await page.evaluate(fs.readFileSync(axeSource, 'utf8'));
for (const theme of ['light', 'dark']) {
  const shown = await page.getAttribute('html', 'data-theme');
  if (shown !== theme) await page.keyboard.press('t');
  const {violations} = await page.evaluate(() => window.axe.run());
  for (const each of violations) {
    const serious = ['serious', 'critical'].includes(each.impact);
    const where = each.nodes.map(node => node.target.join(' ')).join('; ');
    if (serious) check(false, `axe, ${theme}: ${each.help} (${where})`);
    else console.log(`axe, ${theme}, ${each.impact}: ${each.help} (${where})`);
  }
}
await page.keyboard.press('t');
if (picture) await page.screenshot({path: picture});
await finish(browser, faults);

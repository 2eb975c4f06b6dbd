// How fast a page draws: node frames.mjs ADDRESS SECONDS. With every plot; prints JSON: frames a second and script a frame, by the second.
import {open} from './browser.mjs';

const [address, seconds] = process.argv.slice(2);
const {browser, page, faults} = await open(address);
await page.waitForFunction(() => document.querySelector('#reach').textContent.includes('mm away'), null, {timeout: 120000});
await page.click('.menu summary');
for (const box of await page.locator('#plot-choice input').all()) await box.check();
await page.click('.menu summary');
await page.waitForTimeout(3000);
const frames = [], script = [];
for (let k = 0; k < Number(seconds); ++k) {
  await page.waitForTimeout(1000);
  const {framesPerS, scriptMs} = await page.evaluate(() => ({...document.documentElement.dataset}));
  frames.push(Number(framesPerS));
  script.push(Number(scriptMs));
}
console.log(JSON.stringify({frames, script, faults}));
await browser.close();

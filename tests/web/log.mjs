// Drives the page of a log in a headless Chromium: node log.mjs ADDRESS [FOLDER FOR PICTURES]. Prints a line that begins with FAILED for what
// does not hold. The log is of six seconds of logs/reach.lcm, and another run with motion: track is given.
import {axeSource, open} from './browser.mjs';
import fs from 'node:fs';

const [address, folder] = process.argv.slice(2);
let failures = 0;
function check(holds, sentence) {
  if (holds) return;
  ++failures;
  console.log(`FAILED: ${sentence}`);
}
const kPatience = {timeout: 60000};

const {browser, page, faults} = await open(address);
const text = selector => page.textContent(selector);
const contains = (selector, part) =>
  page.waitForFunction(([where, words]) => document.querySelector(where)?.textContent.includes(words), [selector, part], kPatience)
    .catch(async () => check(false, `${selector} does not say '${part}' but '${await text(selector).catch(() => 'nothing')}'`));
const holds = (condition, argument, sentence) => page.waitForFunction(condition, argument, kPatience).catch(() => check(false, sentence));
const seconds = async () => Number((await text('#log-position')).split(' ')[0]);

// The views of the log, and the time line with pictures of the session.
await contains('#log-position', 'of 6.');
await contains('#bridge', 'no BRIDGE_STATE yet');
await holds(() => Number(document.querySelector('#time-line').dataset.pictures) > 5, null, 'the time line has no pictures');
await page.focus('#time-line');
await page.keyboard.press('End');
await contains('#bridge', 'running');
await contains('#reach', 'target ball');
await contains('#reach', 'mm away');
await contains('#rates', 'joint command 1000');
check(await page.isHidden('#stop'), 'a log offers to stop a robot');

// Scrubbed, stepped by message, played, paused.
const line = await page.locator('#time-line').boundingBox();
await page.mouse.move(line.x + 0.2 * line.width, line.y + 30);
await page.mouse.down();
await page.mouse.move(line.x + 0.4 * line.width, line.y + 30, {steps: 5});
await page.mouse.move(line.x + 0.5 * line.width, line.y + 30);
await page.mouse.up();
await holds(() => Math.abs(Number(document.querySelector('#log-position').textContent.split(' ')[0]) - 3.1) < 0.3, null, `the middle of the time line is at ${await seconds()} s`);
await page.selectOption('#step-channel', 'TARGET');
await page.keyboard.press('.');
await contains('#stepped', 'TARGET');
await contains('#stepped', 'name ball');
const stepped = await text('#stepped');
await page.keyboard.press('.');
await holds(before => document.querySelector('#stepped').textContent !== before, stepped, 'the second step shows the same message');
await page.keyboard.press(',');
await contains('#stepped', stepped.slice(0, 60));
const before = await seconds();
await page.keyboard.press('Space');
await holds(from => Number(document.querySelector('#log-position').textContent.split(' ')[0]) > from + 0.3, before, 'it does not play');
await page.keyboard.press('Space');
check(await page.getAttribute('#play', 'data-playing') === 'false', 'it does not pause');
if (folder) await page.screenshot({path: `${folder}/log-light.png`});

// Another run over it, and the first difference.
await page.keyboard.press('w');
await holds(() => document.querySelector('#compared').options.length === 2, null, 'the other run is not offered');
await page.selectOption('#compared', {label: 'track.lcm'});
await contains('#first-difference', 'JOINT_SETPOINT, ');
await page.click('text=go there');
await holds(() => Number(document.querySelector('#log-position').textContent.split(' ')[0]) < 1, null, 'it does not go to the difference');

// What if: refused in the program's words, then computed and shown.
await page.fill('input[name="controller.gamma_rad2_m2"]', 'much');
await page.click('#recompute');
await contains('#what-if-error', "controller.gamma_rad2_m2");
await page.fill('input[name="controller.gamma_rad2_m2"]', '40');
await page.click('#recompute');
await holds(() => document.querySelector('#compared').selectedOptions[0].textContent === 'controller.gamma_rad2_m2=40', null, `the run is not shown: ${await text('#runs')}`);
await contains('#first-difference', 'First difference');
await contains('#runs', ' of ');
const difference = await seconds();
await page.click('text=hands furthest apart');
await holds(from => Number(document.querySelector('#log-position').textContent.split(' ')[0]) !== from, difference, 'it does not go to the largest distance');

// The link opens the same view.
await page.keyboard.press('2');
await page.click('#copy-link');
await contains('#answer', 'link');
const link = await page.getAttribute('#answer', 'data-link');
const position = await text('#log-position');
const {browser: other, page: second, faults: otherFaults} = await open(link);
await second.waitForFunction(words => document.querySelector('#log-position')?.textContent === words, position, kPatience).catch(() => check(false, 'the link opens another time'));
await second.waitForFunction(() => document.querySelector('#compared').selectedOptions[0].textContent === 'controller.gamma_rad2_m2=40', null, kPatience)
  .catch(() => check(false, 'the link does not show the compared run'));
check(await second.isVisible('#comparison'), 'the link does not open the panel');
faults.push(...otherFaults);
await other.close();

// Accessible, in light and dark.
await page.evaluate(fs.readFileSync(axeSource, 'utf8'));
for (const theme of ['light', 'dark']) {
  const shown = await page.getAttribute('html', 'data-theme');
  if (shown !== theme) await page.keyboard.press('t');
  const {violations} = await page.evaluate(() => window.axe.run());
  for (const each of violations) {
    if (['serious', 'critical'].includes(each.impact)) check(false, `axe, ${theme}: ${each.help} (${each.nodes.map(node => node.target.join(' ')).join('; ')})`);
  }
  if (folder) await page.screenshot({path: `${folder}/compared-${theme}.png`});
}
const unexpected = faults.filter(fault => !fault.includes('Content Security Policy'));
check(unexpected.length === 0, `the browser reports: ${unexpected.join('; ')}`);
await browser.close();
process.exit(failures ? 1 : 0);

// Drives the page of a running loop in a headless Chromium: node touch.mjs ADDRESS [PICTURE]. Drags the page's target, and the arm follows;
// places and removes an obstacle; pushes the arm. Prints a line that begins with FAILED for what does not hold.
import {open, checks} from './browser.mjs';

const [address, picture] = process.argv.slice(2);
const {browser, page, faults} = await open(address);
const {check, contains, finish} = checks(page);
const kPatience = {timeout: 60000};

const distance = () => page.evaluate(() => Number(/hand ([\d.]+) mm away/.exec(document.querySelector('#reach').textContent)?.[1] ?? NaN));
const reached = what => page.waitForFunction(() => {
  const text = document.querySelector('#reach').textContent;
  return text.includes('target page') && Number(/hand ([\d.]+) mm away/.exec(text)?.[1] ?? 1e9) < 3;
}, null, kPatience).catch(async () => check(false, `${what}: the hand is ${await distance()} mm from the page's target: ${await page.textContent('#reach')}`));
const place = () => page.evaluate(() => ['x', 'y', 'z'].map(axis => Number(document.querySelector(`#at-${axis}`).value)));

await contains('#reach', 'mm away');
await contains('#bridge', 'running');
// By keyboard: the target is taken, and moved by the arrows with Shift.
await page.keyboard.press('g');
await contains('#answer', "the controller follows 'page'");
await contains('#nodes', "target 'page' chosen by the page");
const before = await place();
await page.focus('#scene');
for (let i = 0; i < 2; ++i) await page.keyboard.press('Shift+ArrowUp');
const nudged = await place();
check(Math.hypot(...nudged.map((value, i) => value - before[i])) > 0.01, `the arrows do not move the target: ${before} to ${nudged}`);
await reached('after the arrows');

// By mouse: the handle is where the scene says, and is dragged.
await page.click('[data-view="front"]');
await page.evaluate(() => new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done))));
const at = await page.evaluate(() => window.touchHandle());
const box = await page.locator('#scene').boundingBox();
const [x, y] = [box.x + at.x, box.y + at.y];
await page.mouse.move(x, y);
await page.mouse.down();
for (let i = 1; i <= 8; ++i) await page.mouse.move(x + 3 * i, y + 3 * i);
await page.mouse.up();
const dragged = await place();
check(Math.hypot(...dragged.map((value, i) => value - nudged[i])) > 0.01, `the mouse does not move the target: ${nudged} to ${dragged}`);
await reached('after the mouse');

// An obstacle, and its removal.
await page.keyboard.press('o');
await contains('#answer', 'there is now 1 obstacle');
check(await page.inputValue('#selected') === 'obstacle 0', 'the new obstacle is not selected');
await page.fill('#at-z', '0.5');
await page.keyboard.press('Enter');
await contains('#answer', 'obstacles: done');
// The clearance is the distance from the arm's capsules to the sphere, here by sampling them.
await contains('#reach', 'clearance');
// The controller's next message may still tell the one before the obstacle was moved. A function, not a text: the page's policy forbids eval.
await page.waitForFunction(() => Math.abs(Number(/clearance ([\d.]+) mm/.exec(document.querySelector('#reach').textContent)?.[1] ?? NaN) - window.sampledClearance()) < 3, null, kPatience)
  .catch(async error => check(false, `clearance: the page says '${await page.textContent('#reach')}', by sampling it is ${await page.evaluate(() => window.sampledClearance())} mm: ${error}`));
if (picture) await page.screenshot({path: picture});
await page.focus('#scene');
await page.keyboard.press('Delete');
await contains('#answer', 'there are now 0 obstacles');

// A push moves the arm, which comes back.
await page.keyboard.press('u');
await contains('#answer', 'push: done');
await reached('after the push');

// A second browser may not take the target; after its release the arm follows the ball again.
const second = await open(address);
await second.page.waitForFunction(() => document.querySelector('#reach').textContent.includes('mm away'), null, kPatience);
await second.page.keyboard.press('g');
await second.page.waitForFunction(() => document.querySelector('#answer').textContent.includes('another browser moves the target'), null, kPatience)
  .catch(async () => check(false, `a second browser takes the target: ${await second.page.textContent('#answer')}`));
await second.browser.close();
await page.keyboard.press('g');
await contains('#answer', 'release: done');
await contains('#reach', 'target ball');
await finish(browser, faults);

// A headless Chromium with the page of a run, for tests and pictures.
import {createRequire} from 'node:module';

const require = createRequire(new URL('../../web/package.json', import.meta.url));
const {chromium} = require('playwright-core');

/** Opens the page; software rendering, as on a machine without a GPU. */
export async function open(address, {theme = 'light', width = 1280, height = 800} = {}) {
  const browser = await chromium.launch({
    executablePath: process.env.CHROMIUM ?? '/usr/bin/chromium',
    args: ['--no-sandbox', '--enable-unsafe-swiftshader', '--disable-dev-shm-usage'],
  });
  const page = await browser.newPage({viewport: {width, height}, colorScheme: theme});
  const faults = [];
  page.on('pageerror', error => faults.push(String(error)));
  page.on('console', message => { if (message.type() === 'error') faults.push(message.text()); });
  await page.goto(address);
  return {browser, page, faults};
}

/** Checks of what a page shows, and the end of a test: it exits with 1 when one of them did not hold. */
export function checks(page, patience = 60000) {
  let failures = 0;
  const check = (holds, sentence) => {
    if (holds) return;
    ++failures;
    console.log(`FAILED: ${sentence}`);
  };
  const contains = (selector, part) =>
    page.waitForFunction(([where, words]) => document.querySelector(where).textContent.includes(words), [selector, part], {timeout: patience})
      .catch(async () => check(false, `${selector} does not say '${part}' but '${await page.textContent(selector)}'`));
  const finish = async (browser, faults) => {
    const unexpected = faults.filter(fault => !fault.includes('Content Security Policy'));
    check(unexpected.length === 0, `the browser reports: ${unexpected.join('; ')}`);
    await browser.close();
    process.exit(failures ? 1 : 0);
  };
  return {check, contains, finish};
}

export const axeSource = require.resolve('axe-core/axe.min.js');

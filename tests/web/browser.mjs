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

export const axeSource = require.resolve('axe-core/axe.min.js');

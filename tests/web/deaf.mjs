// A browser that never reads: node deaf.mjs ADDRESS. Opens the messages of the page and lets them pile up until it is killed.
import net from 'node:net';

const {host, hostname, port, hash} = new URL(process.argv[2]);
const socket = net.connect(Number(port), hostname);
socket.pause();
socket.on('error', () => {});
socket.write(`GET /messages?token=${hash.slice(1)} HTTP/1.1\r\nHost: ${host}\r\nOrigin: http://${host}\r\nConnection: Upgrade\r\n` +
             'Upgrade: websocket\r\nSec-WebSocket-Version: 13\r\nSec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\n\r\n');
setTimeout(() => {}, 600000);

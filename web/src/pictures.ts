// Both camera images, side by side.
import type {Picture} from './messages';

export class Pictures {
  private readonly context: CanvasRenderingContext2D;
  received = 0;

  constructor(private readonly canvas: HTMLCanvasElement) {
    this.context = canvas.getContext('2d')!;
    canvas.parentElement!.dataset.empty = 'true';
  }

  async show({side, jpeg}: Picture) {
    let image: ImageBitmap;
    try {
      image = await createImageBitmap(jpeg);
    } catch {
      return;  // a damaged picture; the next one comes soon
    }
    const width = side === 'pair' ? image.width : 2 * image.width;
    if (this.canvas.width !== width || this.canvas.height !== image.height) [this.canvas.width, this.canvas.height] = [width, image.height];
    this.context.drawImage(image, side === 'right' ? image.width : 0, 0);
    image.close();
    delete this.canvas.parentElement!.dataset.empty;
    ++this.received;
  }
}

#!/usr/bin/env python3
"""Makes the files of data: small networks with random weights, what they make of fixed numbers, and gradients.

usage: make_reference.py [FOLDER]
Needs PyTorch (Debian: python3-torch), and is run again only where the layout of networks changes. All in double precision.

generator_reference.safetensors: a StyleGAN2 generator, written as the paper has it [Karras et al. 2020], rather than as is fast:
kernels modulated and demodulated for each image, transposed convolutions, and the filter as a convolution of its own.
discriminator_reference.safetensors: a discriminator of StyleGAN2 in the same way, and its R1 penalty with derivatives.
vgg_reference.safetensors: the first ten convolutions of VGG-19 with few channels, by PyTorch's own modules, and their features.
"""
import json
import math
import os
import struct
import sys

import torch
import torch.nn.functional as F

RESOLUTION, BASE, MAX_MAPS, LATENT, MAPPING, RATE = 16, 128, 12, 16, 3, 0.05
CHANNELS, BATCH = 9, 2
FILTER = torch.outer(torch.tensor([1.0, 3, 3, 1]), torch.tensor([1.0, 3, 3, 1])).double() / 64 * 4


def maps(res):
    return min(BASE // res, MAX_MAPS)


def parameters():
    """Random numbers for everything, biases and strengths of noise too."""
    made = {}

    def styled(name, kernel, fan_in, fan_out):
        made[name + ".weight"] = torch.randn(kernel, kernel, fan_in, fan_out)
        made[name + ".bias"] = torch.randn(fan_out) * 0.3
        made[name + ".style.fc.weight"] = torch.randn(fan_in, LATENT)
        made[name + ".style.bias"] = torch.randn(fan_in) * 0.3

    for i in range(MAPPING):
        made[f"mapping.dense{i}.fc.weight"] = torch.randn(LATENT, LATENT) / RATE
        made[f"mapping.dense{i}.bias"] = torch.randn(LATENT) / RATE * 0.2
    made["synthesis.early_layer.const"] = torch.randn(1, maps(4), 4, 4)
    layer, res = 0, 4
    while res <= RESOLUTION:
        for is_first in [True, False]:
            if is_first and res == 4:
                continue
            name = f"synthesis.layer{layer}"
            styled(name, 3, maps(res // 2 if is_first else res), maps(res))
            made[name + ".noise_strength"] = torch.rand(()) * 0.5 + 0.1
            layer += 1
        styled(f"synthesis.output{(layer - 1) // 2}", 1, maps(res), CHANNELS)
        res *= 2
    # As a file of single precision has them.
    return {name: value.float().double() for name, value in made.items()}


def filtered(x):
    """The filter on each map."""
    n, c, h, w = x.shape
    return F.conv2d(x.reshape(n * c, 1, h, w), FILTER[None, None]).reshape(n, c, h - 3, w - 3)


def modulated(p, name, x, w, doubles, demodulates):
    """Kernels of each image [Karras et al. 2020], eq. 1 and 3."""
    raw = p[name + ".weight"]
    style = w @ p[name + ".style.fc.weight"].t() / math.sqrt(LATENT) + p[name + ".style.bias"] + 1
    images = []
    for image in range(x.shape[0]):
        kernel = raw.permute(3, 2, 0, 1) / math.sqrt(raw.shape[0] * raw.shape[1] * raw.shape[2])
        kernel = kernel * style[image][None, :, None, None]
        if demodulates:
            kernel = kernel / torch.sqrt(kernel.square().sum((1, 2, 3), keepdim=True) + 1e-8)
        one = x[image:image + 1]
        if doubles:
            one = F.conv_transpose2d(one, kernel.transpose(0, 1).flip(2, 3), stride=2)
            one = filtered(F.pad(one, (1, 1, 1, 1)))
        else:
            one = F.conv2d(one, kernel, padding=raw.shape[0] // 2)
        images.append(one)
    return torch.cat(images)


def activated(x):
    return F.leaky_relu(x, 0.2) * math.sqrt(2)


def mapping(p, z):
    x = z / torch.sqrt(z.square().mean(1, keepdim=True) + 1e-8)
    for i in range(MAPPING):
        x = activated(x @ p[f"mapping.dense{i}.fc.weight"].t() * RATE / math.sqrt(LATENT) + p[f"mapping.dense{i}.bias"] * RATE)
    return x


def synthesis(p, w_plus, noise):
    x = p["synthesis.early_layer.const"].expand(w_plus.shape[0], -1, -1, -1)
    image = None
    for layer in range(len(noise)):
        name = f"synthesis.layer{layer}"
        x = modulated(p, name, x, w_plus[:, layer], layer % 2 == 1, True)
        x = activated(x + noise[layer] * p[name + ".noise_strength"] + p[name + ".bias"][None, :, None, None])
        if layer % 2 == 1:
            continue
        name = f"synthesis.output{layer // 2}"
        output = modulated(p, name, x, w_plus[:, layer + 1], False, False) + p[name + ".bias"][None, :, None, None]
        if image is not None:
            n, c, h, w = image.shape
            sparse = torch.zeros(n, c, 2 * h, 2 * w, dtype=image.dtype)
            sparse[:, :, ::2, ::2] = image
            output = output + filtered(F.pad(sparse, (2, 1, 2, 1)))
        image = output
    return image


def write(path, tensors, metadata):
    header, end, numbers = {"__metadata__": metadata}, 0, b""
    for name, tensor in sorted(tensors.items()):
        data = tensor.detach().float().contiguous().numpy().astype("<f4").tobytes()
        header[name] = {"dtype": "F32", "shape": list(tensor.shape), "data_offsets": [end, end + len(data)]}
        end += len(data)
        numbers += data
    text = json.dumps(header, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 8)
    with open(path, "wb") as file:
        file.write(struct.pack("<Q", len(text)) + text + numbers)


def make_vgg(path):
    """Named as torchvision names the network's modules, with means in place of maxima."""
    torch.manual_seed(2)
    channels, modules, fan_in = [4, 4, "pool", 5, 5, "pool", 6, 6, 6, 6, "pool", 7, 7], [], 3
    for size in channels:
        if size == "pool":
            modules.append(torch.nn.AvgPool2d(2))
            continue
        modules += [torch.nn.Conv2d(fan_in, size, 3, padding=1), torch.nn.ReLU()]
        fan_in = size
    network = torch.nn.Sequential(*modules).double()
    with torch.no_grad():
        for value in network.parameters():
            value.copy_((1.7 * value).float().double())
    images = torch.rand(2, 3, 16, 16).double().requires_grad_()
    x = (images - torch.tensor([0.485, 0.456, 0.406])[:, None, None].double()) / torch.tensor(
        [0.229, 0.224, 0.225])[:, None, None].double()
    tensors = {f"features.{name}": value for name, value in network.named_parameters()} | {"check.images": images}
    total, taps = 0, {1: 0, 3: 1, 13: 2, 22: 3}  # behind the rectifiers of conv1_1, conv1_2, conv3_2 and conv4_2
    for index, module in enumerate(network):
        x = module(x)
        if index in taps:
            weights = torch.randn(x.shape).double()
            total = total + (x * weights).sum()
            tensors |= {f"check.features{taps[index]}": x, f"check.weights{taps[index]}": weights}
    total.backward()
    tensors["gradient.check.images"] = images.grad
    write(path, tensors, {"format": "pt"})


def blurred(x, padding):
    """The filter with a gain of 1."""
    return filtered(F.pad(x, (padding,) * 4)) / 4


def judged(p, x):
    """[Karras et al. 2020], fig. 7 c, and at the end [Karras et al. 2018], sec. 3, for one group."""
    def convolved(name, x, **options):
        raw = p[name + ".weight"]
        return F.conv2d(x, raw / math.sqrt(raw[0].numel()), p.get(name + ".bias"), **options)

    x = activated(convolved("discriminator.input", x))
    res = RESOLUTION
    while res > 4:
        name = f"discriminator.block{res}"
        skipped = convolved(name + ".skip", blurred(x, 1), stride=2)
        x = activated(convolved(name + ".conv0", x, padding=1))
        x = activated(convolved(name + ".conv1", blurred(x, 2), stride=2))
        x = (x + skipped) / math.sqrt(2)
        res //= 2
    deviation = torch.sqrt(x.var(0, unbiased=False) + 1e-8).mean()
    x = torch.cat([x, deviation.expand(x.shape[0], 1, 4, 4)], 1)
    x = activated(convolved("discriminator.last", x, padding=1)).flatten(1)
    for name in ("discriminator.dense", "discriminator.output"):
        raw = p[name + ".weight"]
        x = x @ raw.t() / math.sqrt(raw.shape[1]) + p[name + ".bias"]
        x = activated(x) if name == "discriminator.dense" else x
    return x[:, 0]


def make_discriminator(path):
    torch.manual_seed(3)
    shapes = {"discriminator.input": (maps(RESOLUTION), CHANNELS, 1, 1)}
    res = RESOLUTION
    while res > 4:
        shapes |= {f"discriminator.block{res}.conv0": (maps(res), maps(res), 3, 3),
                   f"discriminator.block{res}.conv1": (maps(res // 2), maps(res), 3, 3),
                   f"discriminator.block{res}.skip": (maps(res // 2), maps(res), 1, 1)}
        res //= 2
    shapes |= {"discriminator.last": (maps(4), maps(4) + 1, 3, 3), "discriminator.dense": (maps(4), maps(4) * 16),
               "discriminator.output": (1, maps(4))}
    p = {}
    for name, shape in shapes.items():
        p[name + ".weight"] = torch.randn(shape).double().requires_grad_()
        if not name.endswith(".skip"):
            p[name + ".bias"] = (0.3 * torch.randn(shape[0])).double().requires_grad_()
    images, weights = (torch.rand(4, CHANNELS, RESOLUTION, RESOLUTION) * 2 - 1).double().requires_grad_(), torch.randn(4).double()
    found = judged(p, images)
    gradients = torch.autograd.grad((found * weights).sum(), [images, *p.values()], retain_graph=True)
    slope, = torch.autograd.grad(found.sum(), [images], create_graph=True)
    penalty = slope.square().sum((1, 2, 3)).mean() / 2
    of_penalty = torch.autograd.grad(penalty, list(p.values()), allow_unused=True)
    tensors = p | {"check.images": images, "check.weights": weights, "check.judged": found, "check.penalty": penalty}
    tensors |= {f"gradient.{name}": value for name, value in zip(["check.images", *p], gradients)}
    tensors |= {f"penalty.{name}": value for name, value in zip(p, of_penalty) if value is not None}
    write(path, tensors, {"format": "pt"})


def make_generator(path):
    torch.manual_seed(1)
    p = {name: value.requires_grad_() for name, value in parameters().items()}
    resolutions = [4]
    while resolutions[-1] < RESOLUTION:
        resolutions += [2 * resolutions[-1]] * 2

    def latent(*shape):
        return torch.randn(*shape).double().requires_grad_()

    z = latent(BATCH, LATENT)
    w_plus = latent(BATCH, len(resolutions) + 1, LATENT)
    noise = [latent(BATCH, 1, res, res) for res in resolutions]
    weights = torch.randn(BATCH, CHANNELS, RESOLUTION, RESOLUTION).double()
    w = mapping(p, z)
    image = synthesis(p, w_plus, noise)
    # What the gradients are of: a weighted sum of the image, and the sum of squares of w.
    ((image * weights).sum() + w.square().sum()).backward()
    tensors = dict(p)
    tensors |= {"check.z": z, "check.w": w, "check.wPlus": w_plus, "check.image": image, "check.weights": weights}
    tensors |= {f"check.noise{i}": map for i, map in enumerate(noise)}
    inputs = {"check.z": z, "check.wPlus": w_plus} | {f"check.noise{i}": map for i, map in enumerate(noise)}
    tensors |= {f"gradient.{name}": value.grad for name, value in (p | inputs).items()}
    metadata = {"format": "lacquer-stylegan2", "resolution": RESOLUTION, "fmapsBase": BASE, "fmapsMax": MAX_MAPS, "wDim": LATENT,
                "mappingLayers": MAPPING, "lrMultiplier": RATE, "roughnessMin": -1, "roughnessMax": 1}
    write(path, tensors, {key: str(value) for key, value in metadata.items()})


def main():
    folder = sys.argv[1] if len(sys.argv) > 1 else os.path.join(os.path.dirname(os.path.abspath(__file__)), "data")
    make_generator(os.path.join(folder, "generator_reference.safetensors"))
    make_discriminator(os.path.join(folder, "discriminator_reference.safetensors"))
    make_vgg(os.path.join(folder, "vgg_reference.safetensors"))


main()

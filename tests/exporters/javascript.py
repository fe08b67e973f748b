"""Functions of `to_javascript` run on many inputs, by Node, or by Chromium where there is none."""

import shutil
import subprocess
from base64 import b64decode, b64encode

import numpy as np

from ..helpers.browsing import chromium

NODE = shutil.which("node") or shutil.which("nodejs")
RUN = """\
const columns = v => typeof v === "number" ? [v] : Array.isArray(v[0]) ? v[0].flatMap((_, c) => v.map(r => r[c])) : v;
function run(base64, calls, inputs, outputs) {
  const bytes = Uint8Array.from(atob(base64), letter => letter.charCodeAt(0));
  const numbers = new Float64Array(bytes.buffer), count = numbers.length / inputs;
  const found = new Float64Array(count * outputs);
  for (let k = 0; k < count; k++) found.set(calls(numbers.subarray(k * inputs, (k + 1) * inputs)), k * outputs);
  let text = "";
  for (const byte of new Uint8Array(found.buffer)) text += String.fromCharCode(byte);
  return btoa(text);
}
"""


def run(code, function, samples):
    """Results (n, all elements by columns) of inputs (n, all elements), by code that defines the casadi.Function."""
    ends = np.cumsum([0, *(function.numel_in(k) for k in range(function.n_in()))]).tolist()
    given = [f"x[{a}]" if b - a == 1 else f"x.subarray({a}, {b})" for a, b in zip(ends, ends[1:])]
    parts = ", ".join(f"...columns(found.{function.name_out(k)})" for k in range(function.n_out()))
    call = f"x => {{ const found = {function.name()}({', '.join(given)}); return [{parts}]; }}"
    outputs = sum(function.numel_out(k) for k in range(function.n_out()))
    packed = b64encode(np.ascontiguousarray(samples, dtype=float).tobytes()).decode()
    body = f"'use strict';\n{code}{RUN}return run('{packed}', {call}, {ends[-1]}, {outputs});"
    if NODE:
        program = f"process.stdout.write((() => {{ {body} }})());"
        done = subprocess.run([NODE, "-"], input=program, capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
        text = done.stdout
    else:
        with chromium() as browser:
            text = browser.new_page().evaluate(f"() => {{ {body} }}")
    return np.frombuffer(b64decode(text)).reshape(len(samples), outputs)

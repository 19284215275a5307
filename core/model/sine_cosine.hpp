// Sine and cosine that are the same bits on every machine: C libraries' own differ in the last one, and a
// turned model's masks must not. Thread-safe (no shared state).
#pragma once

namespace contourd {

struct SineCosine {
  double sine, cosine;
};

// Of an angle in degrees, each within two units in the last place; quarter turns are exact.
// REQUIRES: a finite angle.
[[nodiscard]] SineCosine sine_cosine(double degrees);

}  // namespace contourd

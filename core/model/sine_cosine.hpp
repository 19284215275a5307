// Sine and cosine with the same bits on every machine: the functions of C libraries differ in the last bit,
// and a turned model's masks must not. Thread-safe (no shared state).
#pragma once

namespace contourd {

struct SineCosine {
  double sine, cosine;
};

// Returns the sine and cosine of an angle in degrees, each within two units in the last place; quarter turns
// are exact. REQUIRES: a finite angle.
[[nodiscard]] SineCosine sine_cosine(double degrees);

}  // namespace contourd

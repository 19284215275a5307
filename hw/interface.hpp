// The base of all interfaces: their objects are neither copied nor moved, and are destroyed through them.
#pragma once

namespace contourd {

class Interface {
 public:
  Interface() = default;
  Interface(const Interface&) = delete;
  Interface& operator=(const Interface&) = delete;
  virtual ~Interface() = default;
};

}  // namespace contourd

// The cells of a cavity that a lattice of struts fills. Not thread-safe; does not allocate.
#pragma once

#include <array>
#include <cstdint>

#include "core/hollow/cavity_grid.hpp"
#include "core/hollow/hollow_settings.hpp"

namespace contourd {

class InfillStruts {
 public:
  // Makes a lattice with a node at (0, 0, 0) of the model's coordinates.
  InfillStruts(const InfillLattice& lattice, const CavityGrid& grid) : lattice_(lattice), grid_(grid) {}

  // Moves to a slice.
  void begin(std::int32_t slice);
  // True if the middle of a cell of the slice lies in a strut.
  [[nodiscard]] bool fills(std::int32_t column, std::int32_t row) const;

 private:
  InfillLattice lattice_;
  CavityGrid grid_;
  double z_ = 0;
};

}  // namespace contourd

// The cavities of a hollowed model and the holes that open them, as a source of sections to be cut out of it.
// A cavity is made of cells (see CavityGrid); a section is that of the cells' slice, as one rectangle for
// each run of cells. Immutable; thread-safe.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "core/engine/section_source.hpp"
#include "core/hollow/cavity_grid.hpp"

namespace contourd {

// The cells [first, end) of a row.
struct CavityRun {
  std::uint16_t row, first, end;
};

class Cavity final : public SectionSource {
 public:
  // `starts` has the index in `runs` of each slice's first run, and their number at its end. `holes` is null
  // if there are none.
  Cavity(const CavityGrid& grid, std::vector<std::uint32_t> starts, std::vector<CavityRun> runs,
         std::shared_ptr<const SectionSource> holes);

  // Replaces `contours` by the section at the model's own z, in the model's own millimetres.
  void section_at(Nanometers z, Contours& contours) const override;

 private:
  CavityGrid grid_;
  std::vector<std::uint32_t> starts_;
  std::vector<CavityRun> runs_;
  std::shared_ptr<const SectionSource> holes_;
};

}  // namespace contourd

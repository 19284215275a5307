#include "core/contour/crack_survey.hpp"

#include "core/contour/contour_loops.hpp"
#include "core/contour/slicer.hpp"

namespace contourd {

CrackSurvey survey_cracks(const StandingModel& model, std::span<const Nanometers> heights,
                          Millimeters tolerance) {
  CrackSurvey survey;
  Section section;
  ContourLinker linker;
  Contours contours;
  std::int32_t layer = 0;
  for (const Nanometers height : heights) {
    slice_at(*model.model, model.z_at(height), section);
    if (!section.balanced) {
      linker.link(section.segments, tolerance, contours);
      survey.cracks += contours.cracks;
      survey.wide_layers += contours.cracks.widest_gap > kWideGap * tolerance ? 1 : 0;
      if (contours.cracks.has_guesses()) {
        ++survey.open_layers;
        if (!survey.first_open) survey.first_open = layer;
      }
    }
    ++layer;
  }
  return survey;
}

}  // namespace contourd

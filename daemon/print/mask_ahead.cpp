#include "daemon/print/mask_ahead.hpp"

#include <pthread.h>

#include <array>
#include <exception>

#include "core/contract/expects.hpp"
#include "daemon/print/mask_cost.hpp"

namespace contourd {
namespace {

// Makes each pixel as much darker as white pixels are: light is a power of grey.
void darken(Mask& mask, std::uint8_t white) {
  std::array<std::uint8_t, 256> darker{};
  for (unsigned grey = 0; grey < darker.size(); ++grey)
    darker[grey] = static_cast<std::uint8_t>((grey * white + 127) / 255);
  for (std::int32_t y = 0; y < mask.height().count(); ++y)
    for (std::uint8_t& pixel : mask.row(y))
      pixel = darker[pixel];
}

}  // namespace

MaskAhead::MaskAhead(ContourEngine& engine, const Clock& clock, Duration budget)
    : engine_(engine), clock_(clock), budget_(budget), thread_([this] {
        (void)::pthread_setname_np(::pthread_self(), "contourd-masks");
        work();
      }) {}

MaskAhead::~MaskAhead() {
  phase_ = Phase::Ended;
  phase_.notify_all();
}

void MaskAhead::begin(Nanometers height, std::uint8_t white) {
  expects(!busy(), "no mask is being cut");
  cuts_[1 - taken_].height = height;
  cuts_[1 - taken_].white = white;
  begun_ = true;
  phase_ = Phase::Asked;
  phase_.notify_all();
}

bool MaskAhead::busy() const {
  if (clock_.skips_waiting()) phase_.wait(Phase::Asked);
  return phase_ == Phase::Asked;
}

const MaskAhead::Cut& MaskAhead::take() {
  expects(ready(), "a mask is ready");
  begun_ = false;
  taken_ = 1 - taken_;
  return cuts_[taken_];
}

void MaskAhead::work() {
  for (;;) {
    phase_.wait(Phase::Idle);
    if (phase_ == Phase::Ended) return;
    cut(cuts_[1 - taken_]);
    Phase asked = Phase::Asked;
    phase_.compare_exchange_strong(asked, Phase::Idle);
    phase_.notify_all();
  }
}

void MaskAhead::cut(Cut& cut) {
  const auto start = MaskBudget::Clock::now();
  MaskBudget budget(start + budget_);
  cut.trouble.clear();
  try {
    if (const Mask* const mask = engine_.mask_within(cut.height, budget)) {
      cut.mask = *mask;
      if (cut.white < 255) darken(cut.mask, cut.white);
      cut.lit_area = engine_.coverage().lit_area();
    } else {
      cut.trouble = describe_mask_cost(engine_, budget, MaskBudget::Clock::now() - start);
    }
  } catch (const std::exception& error) {
    cut.trouble = error.what();
  }
  cut.time = MaskBudget::Clock::now() - start;
}

}  // namespace contourd

// One single-start fit of one record, six unknowns: ours against a program of the kind that people write in Python,
// with SciPy's solve_ivp and events, and with the closed form in NumPy.
//
// The peer is not part of this project. It is looked for at UICLINK_PEER_FIT, else at kPeer beside the project's
// folder; UICLINK_PYTHON names a Python that has SciPy. Without them our side is measured alone.

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

#include "identify/fit_problem.h"
#include "identify/record.h"
#include "measurements/rig/rig.h"
#include "tests/bench/ratio.h"
#include "tests/cli/program_run.h"
#include "tests/cli/temporary_folder.h"

namespace uiclink {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr const char* kPeer = "../shared/reference/peer_scipy_fit.py";  // from the project's folder
constexpr int kFits = 50;                                               // of ours for one of theirs
constexpr int kPeerFits = 5;                                            // each a process of its own
constexpr double kTolerance = 1e-10;  // relative fall of the sum of squares at which the peer stops, and we do
/// Largest difference of the two motions [mm]: a twentieth of the noise of a reading.
constexpr double kSameMotion = 1e-3;

/// Runs Python programs, if there is a Python with SciPy.
class Python {
 public:
  Python() {
    std::vector<std::string> candidates = {"python3", "/usr/bin/python3"};
    if (const char* given = std::getenv("UICLINK_PYTHON")) candidates = {given};
    for (const std::string& candidate : candidates) {
      if (RunProgram({"/usr/bin/env", candidate, "-c", "import scipy"}, {.folder = "."}).exit_code != 0) continue;
      command_ = candidate;
      return;
    }
  }
  bool found() const { return !command_.empty(); }

  /// The JSON that a program prints. @throws std::runtime_error when it fails.
  json Run(std::vector<std::string> words) const {
    // One thread on their side, as on ours.
    words.insert(words.begin(), {"/usr/bin/env", "OMP_NUM_THREADS=1", "OPENBLAS_NUM_THREADS=1", command_});
    const ProgramResult run = RunProgram(words, {.folder = "."});
    if (run.exit_code != 0) throw std::runtime_error(fmt::format("{}: {}", words[4], run.err));
    return json::parse(run.out);
  }

 private:
  std::string command_;
};

std::string FindPeer() {
  if (const char* given = std::getenv("UICLINK_PEER_FIT")) return given;
  return (fs::path(UICLINK_SOURCE_DIR) / kPeer).lexically_normal().string();
}

/// A free decay that starts at rest at its first sample, so that both programs have the same unknowns: the peer's are
/// displacement and velocity at the first sample, ours displacement and time of the extremum.
struct Decay {
  std::string name;
  double k, k1, T0;  // [1/m], [1/m], [-]
  double y0;         // [m]
  double duration;   // [s]
};

constexpr double kStep = 0.005;   // [s], 200 Hz
constexpr double kNoise = 2e-5;   // [m], rms
constexpr double kOffset = 4e-4;  // [m]

/// Made by the rig, which shares nothing with either solver.
std::string MakeRecordText(const Decay& decay) {
  constexpr double kRigStep = 1e-4;
  const auto every = static_cast<std::size_t>(std::lround(kStep / kRigStep));
  rig::Link link;
  link.k = decay.k;
  link.joints = {{.k = decay.k1, .T0 = decay.T0}};
  const rig::FreeDecay motion = rig::ReleaseFromExtremum(link, decay.y0, decay.duration, kRigStep);
  std::mt19937_64 random(2003);
  std::normal_distribution<double> noise(0, kNoise);
  std::string text = "# direction: lateral\n";
  for (std::size_t i = 0; i < motion.y.size(); i += every)
    text += fmt::format("{:.3f} {:.6f}\n", motion.t[i], 1e3 * (motion.y[i] + kOffset + noise(random)));
  return text;
}

/// An engine of the peer.
struct Engine {
  const char* name;
  const char* option;  // --engine
  const char* method;  // --method, of solve_ivp
  double least_ratio;  // what we promise of its time over ours
  bool same_motion;    // it computes the motion to kSameMotion
  /// Largest difference of the fits [standard errors].
  double largest_difference;
  bool windows;  // takes part in the fits through growing windows, too (a minute for the slowest)
};
/// A locked slider touches its limit, at rest, once per period. DOP853, which is fastest, takes some touch for an event
/// or misses one, whatever its tolerance (up to 6e-3 mm at rtol 1e-8, 7e-2 mm at 1e-9); the fit then ends up to a
/// standard error away. RK45 with its shorter steps is the fastest that computes the same motion as everybody else.
/// What is left between equal motions are the differences that the peer takes for derivatives.
constexpr Engine kEngines[] = {{"NumPy closed form", "exact", "DOP853", 10, true, 0.05, true},
                               {"solve_ivp DOP853", "ivp", "DOP853", 500, false, 3, true},
                               {"solve_ivp RK45", "ivp", "RK45", 500, true, 0.05, false}};

/// The unknowns of a fit as the peer has them; y0 is a reading. Units: 1/m, 1/m, -, mm, mm/s, mm.
using PeerValues = std::array<double, 6>;

PeerValues ReadValues(const json& object) {
  constexpr std::array kNames = {"k", "k1", "T0", "y0_mm", "v0_mm_s", "offset_mm"};
  PeerValues values{};
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = object.at(kNames[i]);
  return values;
}

/// One record and both ways to fit it.
class Case {
 public:
  Case(const Decay& decay, const Python& python, std::string peer) : python_(python), peer_(std::move(peer)) {
    folder_.Write("lateral.txt", MakeRecordText(decay));
    record_ = ReadRecord(File());
    data_ = {.record = &record_, .first = 0, .size = record_.t.size(), .sigma = kNoise, .g = record_.g};
    truth_.k = decay.k;
    truth_.Add({.k = decay.k1, .T0 = decay.T0});
    y0_ = decay.y0;
  }

  /// Both start from the truth times these factors (k, k1, T0), the first reading, at rest, and a zero of 0.
  void StartFrom(const std::array<double, 3>& factors) {
    const Slider<double>& slider = truth_.sliders()[0];
    Oscillator<double> link;
    link.k = factors[0] * truth_.k;
    link.Add({.k = factors[1] * slider.k, .T0 = factors[2] * slider.T0});
    initial_.levels.resize(1);
    FromOscillator(link, &initial_.levels[0], &initial_.shape);
    initial_.starts = {{record_.y[0], record_.t[0], 0}};
    start_ = {link.k, link.sliders()[0].k, link.sliders()[0].T0, 1e3 * record_.y[0], 0, 0};
  }

  void FitOurs(bool windows) {
    FitControl control{.function_tolerance = kTolerance};
    const double length = record_.t.back() - record_.t.front();
    if (windows) control.window_s = {0.15 * length, 0.3 * length, 0.6 * length};  // as the peer grows them
    outcome_ = Fit({&data_, 1}, Sharing::kLink, initial_, control);
  }
  const FitOutcome& outcome() const { return outcome_; }

  /// @returns the peer's processor time without starting Python [s].
  double FitTheirs(const Engine& engine, bool windows) {
    theirs_ = RunPeer(engine, windows);
    return theirs_.at("cpu_s");
  }
  int simulations() const { return theirs_.at("simulations"); }

  /// Largest difference of k, k1, T0 and offset between the fits, in the peer's standard errors. (Its y0 and v0 belong
  /// to the first sample, ours to the extremum.)
  double Difference() const {
    const PeerValues value = ReadValues(theirs_.at("parameters")), error = ReadValues(theirs_.at("std_error"));
    const Oscillator<double> link = ToOscillator(outcome_.state.levels[0], outcome_.state.shape, record_.g);
    const double offset_mm = 1e3 * outcome_.state.starts[0][2];
    const PeerValues ours = {link.k, link.sliders()[0].k, link.sliders()[0].T0, value[3], value[4], offset_mm};
    double worst = 0;
    for (std::size_t i = 0; i < ours.size(); ++i) worst = std::max(worst, std::abs(ours[i] - value[i]) / error[i]);
    return worst;
  }

  /// The two motions at the truth: largest difference [mm], and processor time of one run on either side [s].
  struct Forward {
    double difference = 0, ours = 0, theirs = 0;
  };
  Forward CompareForward(const Engine& engine) {
    FitState truth;
    truth.levels.resize(1);
    FromOscillator(truth_, &truth.levels[0], &truth.shape);
    const Start start = {y0_, record_.t[0], 0};
    std::vector<double> residuals;
    const Side ours = Timed("", 200, [&] { residuals = CalcResiduals(data_, truth.levels[0], truth.shape, start); });
    Forward forward;
    forward.ours = ours.seconds();
    const Slider<double>& slider = truth_.sliders()[0];
    const json motion = python_.Run(
        {(fs::path(UICLINK_SOURCE_DIR) / "tests/bench/scipy_forward.py").string(), peer_, engine.option, engine.method,
         std::to_string(record_.t.size()), fmt::format("{}", kStep), fmt::format("{:.17g}", truth_.k),
         fmt::format("{:.17g}", slider.k), fmt::format("{:.17g}", slider.T0), fmt::format("{:.17g}", 1e3 * y0_)});
    for (std::size_t i = 0; i < residuals.size(); ++i) {
      const double y_mm = 1e3 * (residuals[i] + record_.y[i]);
      forward.difference = std::max(forward.difference, std::abs(y_mm - motion.at("y_mm")[i].get<double>()));
    }
    forward.theirs = motion.at("cpu_s");
    return forward;
  }

 private:
  fs::path File() const { return folder_.path() / "lateral.txt"; }

  json RunPeer(const Engine& engine, bool windows) const {
    std::vector<std::string> words = {
        peer_,      File().string(), "--engine", engine.option,
        "--method", engine.method,   "--p0",     fmt::format("{:.17g}", fmt::join(start_, ","))};
    if (windows) words.push_back("--windows");
    return python_.Run(words);
  }

  const Python& python_;
  std::string peer_;
  TemporaryFolder folder_;
  Record record_;
  FitData data_;
  Oscillator<double> truth_;
  double y0_ = 0;
  PeerValues start_{};
  FitState initial_;
  FitOutcome outcome_;
  json theirs_;
};

/// How a fit goes through the record, from where, and what we promise.
struct Task {
  const char* words;
  bool windows;
  std::array<double, 3> start;  // factors on k, k1, T0
};
/// At once, from a start as good as one read off the record; or through 15, 30, 60 and 100 % of it, from one that is
/// not.
constexpr Task kTasks[] = {{"whole record", false, {1.02, 0.9, 1.1}}, {"growing windows", true, {1.2, 0.7, 1.4}}};

/// First the motions: speed means nothing where these differ. @returns false when they do.
bool PrintForward(const std::string& name, Case* fit_case) {
  bool same = true;
  for (const Engine& engine : kEngines) {
    const Case::Forward forward = fit_case->CompareForward(engine);
    const bool differs = engine.same_motion && !(forward.difference <= kSameMotion);
    fmt::print("{}, one motion: {} ours, {} {}; they differ by {:.1e} mm{}\n", name, FormatDuration(forward.ours),
               FormatDuration(forward.theirs), engine.name, forward.difference, differs ? "  MOTIONS DIFFER" : "");
    same &= !differs;
  }
  return same;
}

/// Our side alone, where there is nothing to compare with.
void PrintOurs(const std::string& name, const Task& task, Case* fit_case) {
  const double seconds = Timed("", kFits, [&] { fit_case->FitOurs(task.windows); }).seconds();
  fmt::print("{}, {}: {} for {} simulations\n", name, task.words, FormatDuration(seconds),
             fit_case->outcome().evaluations);
}

Comparison MakeComparison(const std::string& record, const Task& task, const Engine& engine,
                          const std::shared_ptr<Case>& fit_case) {
  const std::string name = fmt::format("{}, {}, {}", record, task.words, engine.name);
  return {.name = name,
          .ours = Timed("exact solver and derivatives, Ceres", kFits, [=] { fit_case->FitOurs(task.windows); }),
          .theirs = {fmt::format("{}, least_squares", engine.name),
                     [=] { return fit_case->FitTheirs(engine, task.windows); }},
          .least_ratio = engine.least_ratio,
          .difference =
              [=] {
                fmt::print("{}: {} simulations ours, {} theirs\n", name, fit_case->outcome().evaluations,
                           fit_case->simulations());
                return fit_case->Difference();
              },
          .largest_difference = engine.largest_difference,
          .unit = "standard errors",
          .iterations = kPeerFits};
}

int Main(int argc, char** argv) {
  // Set 1 of the thesis (table 4.1), k1 < k: every half swing slips, for ever. And k of set 2 with k + k1 as measured.
  const std::vector<Decay> decays = {
      {.name = "set 1", .k = 4.2010, .k1 = 1.4222, .T0 = 0.014, .y0 = 0.030, .duration = 12},
      {.name = "hybrid", .k = 3.41, .k1 = 2.21, .T0 = 0.018, .y0 = 0.025, .duration = 12}};
  const Python python;
  const std::string peer = FindPeer();
  const bool compare = python.found() && fs::exists(peer);
  if (!compare)
    fmt::print("Nothing to compare with: {}. Ours alone:\n",
               python.found() ? "no peer program at " + peer : "no Python that has SciPy");
  std::vector<Comparison> comparisons;
  bool same = true;
  for (const Decay& decay : decays) {
    if (compare) same &= PrintForward(decay.name, std::make_shared<Case>(decay, python, peer).get());
    for (const Task& task : kTasks) {
      const auto fit_case = std::make_shared<Case>(decay, python, peer);
      fit_case->StartFrom(task.start);
      if (!compare) PrintOurs(decay.name, task, fit_case.get());
      for (const Engine& engine : kEngines)
        if (compare && (engine.windows || !task.windows))
          comparisons.push_back(MakeComparison(decay.name, task, engine, fit_case));
    }
  }
  const int status = RunComparisons(argc, argv, comparisons);
  return same ? status : std::max(status, 1);
}

}  // namespace
}  // namespace uiclink

int main(int argc, char** argv) {
  try {
    return uiclink::Main(argc, argv);
  } catch (const std::exception& error) {  // the peer does not run
    fmt::print(stderr, "bench_fit: {}\n", error.what());
    return 2;
  }
}

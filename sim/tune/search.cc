#include "sim/tune/search.h"

#include <nlopt.h>

#include <exception>
#include <memory>
#include <vector>

#include "sim/tune/cma_es.h"

namespace sim::tune {
namespace {

void search_by_cma_es(Study& study, int trials) {
  const Spec& spec = study.spec();
  std::vector<double> start;
  for (const Parameter& p : spec.parameters) start.push_back(p.coordinate_of(p.start));
  study.evaluate("start", start);
  constexpr double kFirstStep = 0.25;  // of the range
  CmaEs cma_es(start, kFirstStep, spec.population, spec.seed);
  for (int tried = 1; tried + spec.population <= trials; tried += spec.population) {
    std::vector<double> losses;
    const std::vector<std::vector<double>> generation = cma_es.ask();
    study.prefetch(generation);
    for (const std::vector<double>& point : generation)
      losses.push_back(study.evaluate("global", point, Study::Abort::hopeless).loss);
    cma_es.tell(losses);
  }
}

// No exception may pass through NLopt, which is C: it is kept until the search has stopped.
struct Polish {
  Study& study;
  nlopt_opt search;
  std::exception_ptr fault = nullptr;
};

double polish_loss(unsigned count, const double* point, double*, void* data) {
  Polish& polish = *static_cast<Polish*>(data);
  try {
    return polish.study.evaluate("polish", {point, point + count}).loss;
  } catch (...) {
    polish.fault = std::current_exception();
    nlopt_force_stop(polish.search);
    return 0;
  }
}

}  // namespace

void polish(Study& study, int trials) {
  if (trials <= 0) return;
  std::vector<double> point = study.best().point;
  const std::vector<double> low(point.size(), 0), high(point.size(), 1), step(point.size(), 0.06);
  const std::unique_ptr<nlopt_opt_s, decltype(&nlopt_destroy)> search(
      nlopt_create(NLOPT_LN_NELDERMEAD, static_cast<unsigned>(point.size())), &nlopt_destroy);
  nlopt_set_lower_bounds(search.get(), low.data());
  nlopt_set_upper_bounds(search.get(), high.data());
  nlopt_set_initial_step(search.get(), step.data());
  Polish of{study, search.get()};
  nlopt_set_min_objective(search.get(), polish_loss, &of);
  nlopt_set_maxeval(search.get(), trials);
  nlopt_set_xtol_abs1(search.get(), 1e-4);
  double loss = 0;
  nlopt_optimize(search.get(), point.data(), &loss);
  if (of.fault) std::rethrow_exception(of.fault);
}

void search(Study& study) {
  const Spec& spec = study.spec();
  search_by_cma_es(study, spec.trials - spec.polish);
  polish(study, spec.trials - static_cast<int>(study.candidates().size()));
}

}  // namespace sim::tune

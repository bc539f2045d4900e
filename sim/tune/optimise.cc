#include "sim/tune/optimise.h"

#include <nlopt.h>

#include <algorithm>
#include <cmath>
#include <exception>
#include <memory>
#include <pagmo/algorithm.hpp>
#include <pagmo/algorithms/de.hpp>
#include <pagmo/algorithms/nsga2.hpp>
#include <pagmo/population.hpp>
#include <pagmo/problem.hpp>

#include "sim/tune/cma_es.h"

namespace sim::tune {
namespace {

// The study as pagmo knows a problem.
struct Problem {
  Study* study = nullptr;

  pagmo::vector_double fitness(const pagmo::vector_double& parts) const {
    return study->evaluate("global", parts, true).values;
  }
  std::pair<pagmo::vector_double, pagmo::vector_double> get_bounds() const {
    const std::size_t n = study ? study->spec().parameters.size() : 1;
    return {pagmo::vector_double(n, 0), pagmo::vector_double(n, 1)};
  }
  pagmo::vector_double::size_type get_nobj() const { return study ? study->spec().objectives.size() : 1; }
};

pagmo::algorithm algorithm(const Spec& spec, unsigned generations) {
  const auto seed = static_cast<unsigned>(spec.seed);
  constexpr double kFlat = 1e-9;  // of values and settings
  if (spec.optimiser == Optimiser::differential_evolution)
    return pagmo::algorithm(pagmo::de(generations, 0.8, 0.9, 2, kFlat, kFlat, seed));
  return pagmo::algorithm(
      pagmo::nsga2(generations, 0.95, 10, 1.0 / static_cast<double>(spec.parameters.size()), 20, seed));
}

std::vector<double> start_of(const Spec& spec) {
  std::vector<double> parts;
  for (const Parameter& p : spec.parameters) parts.push_back(p.part_of(p.start));
  return parts;
}

// The start, and the rest of the population anywhere.
void search_by_pagmo(Study& study, int trials) {
  const Spec& spec = study.spec();
  pagmo::population population(pagmo::problem(Problem{&study}), 0, static_cast<unsigned>(spec.seed));
  const std::vector<double> start = start_of(spec);
  population.push_back(start, study.evaluate("start", start).values);
  for (int i = 1; i < spec.population; ++i) population.push_back(population.random_decision_vector());
  const int generations = trials / spec.population - 1;
  if (generations > 0) algorithm(spec, static_cast<unsigned>(generations)).evolve(population);
}

void search_by_cma_es(Study& study, int trials) {
  const Spec& spec = study.spec();
  const std::vector<double> start = start_of(spec);
  study.evaluate("start", start);
  constexpr double kFirstStep = 0.25;  // of the range
  CmaEs cma_es(start, kFirstStep, spec.population, spec.seed);
  for (int tried = 1; tried + spec.population <= trials; tried += spec.population) {
    std::vector<double> values;
    const std::vector<std::vector<double>> generation = cma_es.ask();
    study.expect(generation);
    for (const std::vector<double>& parts : generation)
      values.push_back(study.evaluate("global", parts, true).values[0]);
    cma_es.tell(values);
  }
}

// No exception may pass through NLopt, which is C: it is kept until the search has stopped.
struct Polish {
  Study& study;
  nlopt_opt search;
  std::exception_ptr fault = nullptr;
};

double polish_value(unsigned count, const double* parts, double*, void* data) {
  Polish& polish = *static_cast<Polish*>(data);
  try {
    return polish.study.evaluate("polish", {parts, parts + count}).values[0];
  } catch (...) {
    polish.fault = std::current_exception();
    nlopt_force_stop(polish.search);
    return 0;
  }
}

bool dominates(const Candidate& a, const Candidate& b) {
  return a.values[0] <= b.values[0] && a.values[1] <= b.values[1] && a.values != b.values;
}

}  // namespace

void polish(Study& study, int trials) {
  if (trials <= 0) return;
  std::vector<double> parts = study.best().parts;
  const std::vector<double> low(parts.size(), 0), high(parts.size(), 1), step(parts.size(), 0.06);
  const std::unique_ptr<nlopt_opt_s, decltype(&nlopt_destroy)> search(
      nlopt_create(NLOPT_LN_NELDERMEAD, static_cast<unsigned>(parts.size())), &nlopt_destroy);
  nlopt_set_lower_bounds(search.get(), low.data());
  nlopt_set_upper_bounds(search.get(), high.data());
  nlopt_set_initial_step(search.get(), step.data());
  Polish of{study, search.get()};
  nlopt_set_min_objective(search.get(), polish_value, &of);
  nlopt_set_maxeval(search.get(), trials);
  nlopt_set_xtol_abs1(search.get(), 1e-4);
  double value = 0;
  nlopt_optimize(search.get(), parts.data(), &value);
  if (of.fault) std::rethrow_exception(of.fault);
}

void search(Study& study) {
  const Spec& spec = study.spec();
  const int global = spec.trials - (spec.objectives.size() == 1 ? spec.polish : 0);
  spec.optimiser == Optimiser::cma_es ? search_by_cma_es(study, global) : search_by_pagmo(study, global);
  if (spec.objectives.size() == 1) polish(study, spec.trials - static_cast<int>(study.candidates().size()));
}

std::vector<const Candidate*> pareto_front(const std::vector<Candidate>& candidates) {
  std::vector<const Candidate*> front;
  for (const Candidate& c : candidates) {
    const bool beaten = std::any_of(candidates.begin(), candidates.end(), [&](const Candidate& other) {
      return other.complete() && dominates(other, c);
    });
    const bool known = std::any_of(front.begin(), front.end(),
                                   [&](const Candidate* other) { return other->values == c.values; });
    if (c.complete() && !beaten && !known) front.push_back(&c);
  }
  std::sort(front.begin(), front.end(), [](const auto* a, const auto* b) { return a->values < b->values; });
  return front;
}

const Candidate& compromise(const std::vector<const Candidate*>& front) {
  const auto& cheap = front.front()->values;  // least first, greatest second objective
  const auto& dear = front.back()->values;
  const auto scaled = [](double value, double low, double high) {
    return high > low ? (value - low) / (high - low) : 0;
  };
  const auto distance = [&](const Candidate* c) {
    return std::hypot(scaled(c->values[0], cheap[0], dear[0]), scaled(c->values[1], dear[1], cheap[1]));
  };
  return **std::min_element(front.begin(), front.end(),
                            [&](const auto* a, const auto* b) { return distance(a) < distance(b); });
}

}  // namespace sim::tune

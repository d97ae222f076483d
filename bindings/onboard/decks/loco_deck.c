#include "onboard/decks/loco_deck.h"

#include "variable_row.h"

#define TWR_STD 0.25f       // [m]
#define TDOA_STD 0.15f      // [m]
#define HEIGHT_STD 0.0001f  // [m], of the known height in two dimensions

void cf_loco_deck_init(cf_loco_deck_t *deck) {
  *deck = (cf_loco_deck_t){.tdoa2_std = TDOA_STD, .tdoa3_std = TDOA_STD};
}

static measurement_t distance_of(const cf_loco_deck_t *deck, const cf_ranging_t *ranging) {
  const float *a = deck->anchors[ranging->anchor];
  return (measurement_t){
      .type          = MeasurementTypeDistance,
      .data.distance = {.pos      = {a[0], a[1], a[2]},
                        .anchorId = ranging->anchor,
                        .distance = ranging->distance,
                        .stdDev   = TWR_STD},
  };
}

static measurement_t tdoa_of(const cf_loco_deck_t *deck, const cf_ranging_t *ranging,
                             uint32_t tick) {
  const float *a = deck->anchors[ranging->previous];
  const float *b = deck->anchors[ranging->anchor];
  return (measurement_t){
      .type      = MeasurementTypeTDOA,
      .data.tdoa = {.anchorPositionA = {.timestamp = tick, .x = a[0], .y = a[1], .z = a[2]},
                    .anchorPositionB = {.timestamp = tick, .x = b[0], .y = b[1], .z = b[2]},
                    .anchorIdA       = ranging->previous,
                    .anchorIdB       = ranging->anchor,
                    .distanceDiff    = ranging->distance,
                    .stdDev = ranging->mode == CF_LOCO_TDOA2 ? deck->tdoa2_std : deck->tdoa3_std},
  };
}

static void keep(cf_streamed_ranges_t *streamed, const cf_ranging_t *ranging) {
  const uint32_t at       = streamed->written % CF_STREAMED_RANGES;
  streamed->anchors[at]   = ranging->anchor;
  streamed->distances[at] = ranging->distance;
  streamed->written++;
}

void cf_loco_deck_ranging(cf_loco_deck_t *deck, cf_estimator_t *estimator,
                          const cf_ranging_t *ranging, uint32_t tick) {
  if (deck->mode != CF_LOCO_AUTO && deck->mode != ranging->mode) {
    return;
  }
  deck->heard |= (uint16_t)(1u << ranging->anchor);

  measurement_t measurement;
  if (ranging->mode == CF_LOCO_TWR) {
    deck->distances[ranging->anchor] = ranging->distance;
    measurement                      = distance_of(deck, ranging);
    if (deck->streams != 0) {
      keep(&deck->streamed, ranging);
    }
  } else {
    measurement = tdoa_of(deck, ranging, tick);
  }
  cf_estimator_enqueue(estimator, &measurement);

  if (deck->is_planar) {
    const measurement_t height = {
        .type        = MeasurementTypeAbsoluteHeight,
        .data.height = {.timestamp = tick, .height = deck->height, .stdDev = HEIGHT_STD},
    };
    cf_estimator_enqueue(estimator, &height);
  }
}

void cf_loco_deck_count(cf_loco_deck_t *deck) {
  deck->state = deck->heard;
  deck->heard = 0;
}

static const cf_variable_t PARAMETERS[] = {
    CF_ROW("loco", "mode", UINT8, 0, cf_loco_deck_t, mode),
    CF_ROW("tdoa2", "stddev", FLOAT, 0, cf_loco_deck_t, tdoa2_std),
    CF_ROW("tdoa3", "stddev", FLOAT, 0, cf_loco_deck_t, tdoa3_std),
};

#define DISTANCE(i_) CF_ROW("ranging", "distance" #i_, FLOAT, 0, cf_loco_deck_t, distances[i_])

static const cf_variable_t LOGS[] = {
    DISTANCE(0), DISTANCE(1), DISTANCE(2),
    DISTANCE(3), DISTANCE(4), DISTANCE(5),
    DISTANCE(6), DISTANCE(7), CF_ROW("ranging", "state", UINT16, 0, cf_loco_deck_t, state),
};

cf_variables_t cf_loco_deck_parameters(void) {
  return CF_TABLE(PARAMETERS);
}

cf_variables_t cf_loco_deck_logs(void) {
  return CF_TABLE(LOGS);
}

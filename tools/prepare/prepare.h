/* An experiment of which everything is known: what its file (tools/config/config.h) leaves open is
 * chosen by what was measured, and what its scene begins with is solved. Train, solve, eval and
 * everything else begin here. */
#ifndef TOOLS_PREPARE_PREPARE_H
#define TOOLS_PREPARE_PREPARE_H

#include "tools/config/config.h"

/* What is open of a one-step model and a controller that are given; checked. Nothing is solved.
 * AD_BAD_INPUT: the line is as of config_read. */
ad_status prepare_choices(config *config, ad_error *error);

/* The same of what trains a network of the scene: the formulation, network, windows, points and
 * stages; after prepare_choices. Who trains asks for it, and nobody else. It is done once. */
ad_status prepare_training(config *config, ad_error *error);

/* The equilibrium that a motion begins in, and held ends against the beginning; after
 * prepare_choices. Errors also of the solver. */
ad_status prepare_start(config *config, ad_error *error);

/* The choices and the start. */
ad_status prepare_config(config *config, ad_error *error);

/* config_read, config_read_member and config_create with both after them; *result is NULL where
 * anything fails. */
ad_status prepare_read(const char *path, const char *text, int count, const char *const *overrides,
                       config **result, ad_error *error);
ad_status prepare_read_member(const char *path, const char *text, int count,
                              const char *const *overrides, const char *at, config **result,
                              ad_error *error);
ad_status prepare_create(const scene *rod_scene, const train_settings *settings, config **result,
                         ad_error *error);

/* A scene as prepare_read has it, its section control chosen also where it is not given, and the
 * robot that is simulated in its place: the same with the keys of control.plant.set, without
 * control and surrogate. Both are the caller's to free, *nominal also on failure; they are NULL
 * before. What is wrong with the plant is said of control.plant.set. */
ad_status prepare_read_robot(const char *path, int count, const char *const *overrides,
                             config **nominal, config **plant, ad_error *error);

#endif

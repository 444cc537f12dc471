/* Joints at their bounds are fixed there and the law solves again: control/saturation.py. */

/* `brake` of a step in place, with null-space motion in it: whether it was changed; -1: left to Python. */
static int brake(const Law *law, const Limits *l, const double *error, const double *secondary,
                 double *step) {
    const double *o = law->o;
    const int n = law->n, m = law->m;
    double best[MAX_JOINTS], fixed[MAX_JOINTS] = {0.0}, trial[MAX_JOINTS], rest[MAX_JOINTS], more[MAX_JOINTS];
    double longest[MAX_JOINTS], asked[6], left[6], excess[MAX_JOINTS];
    int free_[MAX_JOINTS];
    copy(best, step, n);
    if (!brakeable(o, l, best, n)) return 0;
    copy(trial, step, n);
    task_motion(law, step, asked);
    double most = o[C_BRAKING_GAIN] * nearer(law, asked, best);
    for (int j = 0; j < n; j++) free_[j] = 1;
    for (int pass = 0; pass < (int)o[C_RESOLVES]; pass++) {
        double largest = 0.0, cycles = 1.0;
        int any_free = 0;
        for (int j = 0; j < n; j++) {
            longest[j] = braking(fabs(trial[j]), l->change[j]);
            excess[j] = free_[j] ? fabs(trial[j]) / (longest[j] + o[C_TINY]) : 0.0;
            largest = fmax(largest, excess[j]);
        }
        int slow[MAX_JOINTS];
        for (int j = 0; j < n; j++) {
            slow[j] = free_[j] && excess[j] >= o[C_HALF] * largest;
            free_[j] &= !slow[j], any_free |= free_[j];
        }
        if (!any_free) break;
        for (int j = 0; j < n; j++) if (free_[j]) cycles = fmax(cycles, longest[j] / l->change[j]);
        for (int j = 0; j < n; j++) {
            double longest_ = fmin(longest[j], cycles * l->change[j]);
            if (slow[j]) fixed[j] = copysign(fmin(fabs(trial[j]), longest_), trial[j]);
        }
        for (int j = 0; j < n; j++) rest[j] = free_[j] ? secondary[j] : fixed[j];
        task_motion(law, rest, left);
        for (int i = 0; i < m; i++) left[i] = error[i] - left[i];
        if (!solve(law, left, free_, more)) return -1;
        for (int j = 0; j < n; j++) {
            rest[j] += free_[j] ? more[j] : 0.0;
            trial[j] = free_[j] ? rest[j] : 0.0;
        }
        brakeable(o, l, trial, n);
        for (int j = 0; j < n; j++) if (!free_[j]) trial[j] = fixed[j];
        double near = nearer(law, asked, trial);
        if (near > o[C_BETTER] * most) copy(best, trial, n), most = near;
        copy(trial, rest, n);
    }
    copy(step, best, n);
    return 1;
}

/* `resolve` of a step in place, whose alternative is the step shortened to the speed of the joints. 0: left
 * to Python. */
static int resolve(const Law *law, const Limits *l, const double *error, const double *secondary,
                   const double *low, const double *high, double gain, double *step) {
    const double *o = law->o;
    const int n = law->n, m = law->m, most = n < (int)o[C_RESOLVES] ? n : (int)o[C_RESOLVES];
    double in[MAX_JOINTS], kept[MAX_JOINTS], fixed[MAX_JOINTS] = {0.0}, trial[MAX_JOINTS], more[MAX_JOINTS];
    double asked[6], left[6], excess[MAX_JOINTS];
    int free_[MAX_JOINTS];
    copy(kept, step, n), copy(trial, step, n);
    shorten_by(kept, l->fastest, n);
    task_motion(law, step, asked);
    for (int j = 0; j < n; j++) {
        in[j] = clamped(step[j], low[j], high[j]), kept[j] = clamped(kept[j], low[j], high[j]);
        free_[j] = 1;
    }
    for (int pass = 0; pass < most; pass++) {
        double largest = 0.0;
        int any_free = 0;
        for (int j = 0; j < n; j++) {
            excess[j] = free_[j] ? fabs(trial[j] - in[j]) / (fabs(in[j]) + o[C_TINY]) : 0.0;
            largest = fmax(largest, excess[j]);
        }
        if (!(largest > 0.0)) break;
        for (int j = 0; j < n; j++) {
            if (excess[j] >= o[C_HALF] * largest) free_[j] = 0, fixed[j] = in[j];
            any_free |= free_[j];
        }
        for (int j = 0; j < n; j++) trial[j] = free_[j] ? secondary[j] : fixed[j];
        if (any_free) {
            task_motion(law, trial, left);
            for (int i = 0; i < m; i++) left[i] = error[i] - left[i];
            if (!solve(law, left, free_, more)) return 0;
            for (int j = 0; j < n; j++) if (free_[j]) trial[j] += more[j];
        }
        for (int j = 0; j < n; j++) in[j] = clamped(trial[j], low[j], high[j]);
    }
    double near = nearer(law, asked, in), other = nearer(law, asked, kept);
    copy(step, near > 0.0 && near > gain * other ? in : kept, n);
    return 1;
}

"""Many runs and predictions: which cases (vary), what is computed of each (compute), by whom (engines), kept where (store)."""
